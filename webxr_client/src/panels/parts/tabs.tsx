/** Buttons of which one is pressed: the part of a panel that is shown. */
import type { Signal } from '@preact/signals';
import { Button } from './controls';

interface TabsProps<T extends string> {
  label: string;
  tabs: readonly (readonly [T, string])[];
  chosen: Signal<T>;
}

export function Tabs<T extends string>({ label, tabs, chosen }: TabsProps<T>) {
  return (
    <div class="review-tabs" role="group" aria-label={label}>
      {tabs.map(([tab, words]) => (
        <Button
          key={tab}
          label={words}
          pressed={chosen.value === tab}
          onClick={() => (chosen.value = tab)}
        />
      ))}
    </div>
  );
}
