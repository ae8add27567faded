/** A choice of one of several, as a row of buttons: one tab stop, arrows choose. */
import { focusedByKeys } from '../../common/focus';
import { Icon, type IconName } from '../../common/icons';

export interface RadioOption<T> {
  readonly value: T;
  readonly icon?: IconName;
  readonly label: string;
  readonly tip?: string;
  readonly keys?: string | undefined;
  readonly disabled?: boolean;
}

interface RadioGroupProps<T> {
  label: string;
  class?: string;
  options: readonly RadioOption<T>[];
  value: T | null;
  onChoose: (value: T) => void;
}

export function RadioGroup<T extends string>(props: RadioGroupProps<T>) {
  const { options, value, class: look = 'segmented' } = props;
  const usable = options.filter(({ disabled }) => disabled !== true);
  const stop = usable.find((option) => option.value === value) ?? usable[0];
  return (
    <div class={look} role="radiogroup" aria-label={props.label} onKeyDown={moveFocus}>
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
          {option.icon && <Icon name={option.icon} />}
          <span class="button-label">{option.label}</span>
        </button>
      ))}
    </div>
  );
}

/** One tab stop for several controls: arrows go from one to the next. */
const STEPS: Readonly<Record<string, number>> = {
  ArrowRight: 1,
  ArrowDown: 1,
  ArrowLeft: -1,
  ArrowUp: -1,
};

/** Return the place to which a key leads in a list of `length`, from `at`; null: another key. */
export function nextIndex(key: string, at: number, length: number): number | null {
  if (length === 0) return null;
  if (key === 'Home') return 0;
  if (key === 'End') return length - 1;
  const step = STEPS[key];
  return step === undefined ? null : (at + step + length) % length;
}

/** Handler of the keys of a group of radios or tabs: arrows choose the next one. */
export function moveFocus(event: KeyboardEvent): void {
  if (!focusedByKeys() || event.ctrlKey || event.altKey || event.metaKey) return;
  const group = event.currentTarget as HTMLElement;
  const radios = [
    ...group.querySelectorAll<HTMLElement>(':is([role=radio], [role=tab]):not(:disabled)'),
  ];
  const to = nextIndex(event.key, radios.indexOf(event.target as HTMLElement), radios.length);
  if (to === null) return;
  event.preventDefault();
  radios[to]!.focus();
  radios[to]!.click();
}
