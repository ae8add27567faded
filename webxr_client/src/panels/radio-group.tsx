/** A choice of one of several, as a row of buttons: one tab stop, arrows choose. */
import { Icon } from './icon';
import type { IconName } from './icons';
import { roveRadios } from './roving';

export interface RadioOption<T> {
  readonly value: T;
  readonly icon: IconName;
  readonly label: string;
  readonly tip: string;
  readonly keys?: string | undefined;
  readonly disabled?: boolean;
}

interface RadioGroupProps<T> {
  label: string;
  class: string;
  options: readonly RadioOption<T>[];
  value: T | null;
  onChoose: (value: T) => void;
}

export function RadioGroup<T extends string>(props: RadioGroupProps<T>) {
  const { options, value } = props;
  const usable = options.filter(({ disabled }) => disabled !== true);
  const stop = usable.find((option) => option.value === value) ?? usable[0];
  return (
    <div class={props.class} role="radiogroup" aria-label={props.label} onKeyDown={roveRadios}>
      {options.map((option) => (
        <button
          key={option.value}
          type="button"
          role="radio"
          class="button"
          aria-checked={option.value === value}
          aria-label={option.label}
          tabIndex={option === stop ? 0 : -1}
          data-tip={option.tip}
          data-keys={option.keys || undefined}
          disabled={option.disabled}
          onClick={() => props.onChoose(option.value)}
        >
          <Icon name={option.icon} />
          <span class="button-label">{option.label}</span>
        </button>
      ))}
    </div>
  );
}
