/** Tabs: the arrow keys go from one to the next. */
import { moveFocus } from './radio-group';

interface TabsProps<T extends string> {
  label: string;
  /** Value and text of each, and a count to show beside them. */
  tabs: readonly (readonly [value: T, words: string, count?: number])[];
  chosen: T;
  onChoose: (tab: T) => void;
}

/** Id of a tab, for the panel that it labels. */
export const tabId = (label: string, tab: string): string => `${label.toLowerCase()}-${tab}`;

export function Tabs<T extends string>({ label, tabs, chosen, onChoose }: TabsProps<T>) {
  return (
    <div class="tabs" role="tablist" aria-label={label} onKeyDown={moveFocus}>
      {tabs.map(([tab, words, count = 0]) => (
        <button
          key={tab}
          id={tabId(label, tab)}
          type="button"
          role="tab"
          class="button"
          aria-selected={tab === chosen}
          tabIndex={tab === chosen ? 0 : -1}
          onClick={() => onChoose(tab)}
        >
          {words}
          {count > 0 && <span class="pill warn">{count}</span>}
        </button>
      ))}
    </div>
  );
}
