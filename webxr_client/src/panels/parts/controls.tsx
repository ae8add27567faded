/** Basic controls of the panels. */
import type { ComponentChildren, RefObject } from 'preact';
import { useRef, useState } from 'preact/hooks';
import { Icon, type IconName } from '../../common/icons';

interface ButtonProps {
  icon?: IconName;
  /** Text on the button; without it `tip` names the button. */
  label?: string;
  tip?: string;
  /** The shortcut, shown in the tooltip. */
  keys?: string | undefined;
  pressed?: boolean | undefined;
  expanded?: boolean | undefined;
  disabled?: boolean | undefined;
  kind?: 'outlined' | 'primary' | 'danger';
  small?: boolean;
  tabIndex?: number;
  class?: string;
  buttonRef?: RefObject<HTMLButtonElement | null>;
  /** It submits its form. */
  submit?: boolean;
  onClick?: (event: MouseEvent) => void;
}

export function Button(props: ButtonProps) {
  const kind = props.kind ? ` ${props.kind}` : '';
  const shape = (props.label === undefined ? ' icon-only' : '') + (props.small ? ' small' : '');
  return (
    <button
      type={props.submit ? 'submit' : 'button'}
      ref={props.buttonRef ?? null}
      class={`button${kind}${shape} ${props.class ?? ''}`}
      tabIndex={props.tabIndex}
      aria-label={props.label ?? props.tip}
      aria-pressed={props.pressed}
      aria-expanded={props.expanded}
      aria-haspopup={props.expanded === undefined ? undefined : 'dialog'}
      data-tip={props.tip === props.label ? undefined : props.tip}
      data-keys={props.keys}
      disabled={props.disabled}
      onClick={props.onClick}
    >
      {props.icon && <Icon name={props.icon} />}
      {props.label !== undefined && <span class="button-label">{props.label}</span>}
    </button>
  );
}

interface SureButtonProps {
  /** Text of the second button, such as "Delete". */
  label: string;
  tip: string;
  disabled?: boolean;
  onClick: () => void;
}

/** A button for actions without undo: the first press shows a second button, which acts. */
export function SureButton({ label, tip, disabled, onClick }: SureButtonProps) {
  const [sure, setSure] = useState(false);
  const act = (): void => {
    setSure(false);
    onClick();
  };
  return sure ? (
    <Button label={label} kind="danger" small onClick={act} />
  ) : (
    <Button icon="trash" tip={tip} small disabled={disabled} onClick={() => setSure(true)} />
  );
}

interface SliderProps {
  label: string;
  value: number;
  min: number;
  max: number;
  step?: number;
  /** Equal ways on the slider are equal ratios. */
  logarithmic?: boolean;
  tip?: string;
  keys?: string;
  before?: ComponentChildren;
  class?: string;
  shown?: string;
  disabled?: boolean;
  onInput: (value: number) => void;
}

const LOG_STEPS = 200;

export function Slider(props: SliderProps) {
  const { min, max, value, logarithmic } = props;
  const share = logarithmic
    ? Math.log(value / min) / Math.log(max / min)
    : (value - min) / (max - min);
  const read = (input: HTMLInputElement): number => {
    const raw = Number(input.value);
    return logarithmic ? min * (max / min) ** (raw / LOG_STEPS) : raw;
  };
  return (
    <label class={`slider ${props.class ?? ''}`} data-tip={props.tip} data-keys={props.keys}>
      {props.before ?? <span>{props.label}</span>}
      <input
        type="range"
        aria-label={props.label}
        aria-valuetext={props.shown}
        min={logarithmic ? 0 : min}
        max={logarithmic ? LOG_STEPS : max}
        step={logarithmic ? 1 : (props.step ?? (max - min) / 100)}
        value={logarithmic ? share * LOG_STEPS : value}
        disabled={props.disabled}
        style={{ '--fill': String(share) }}
        onInput={(event) => props.onInput(read(event.currentTarget))}
      />
      {props.shown !== undefined && <output>{props.shown}</output>}
    </label>
  );
}

interface CheckProps {
  label: ComponentChildren;
  checked: boolean;
  tip?: string;
  keys?: string;
  onChange: (checked: boolean) => void;
}

export function Check(props: CheckProps) {
  return (
    <label class="check" data-tip={props.tip} data-keys={props.keys}>
      <input
        type="checkbox"
        checked={props.checked}
        onChange={(event) => props.onChange(event.currentTarget.checked)}
      />
      {props.label}
    </label>
  );
}

export function Progress({ share, label }: { share: number; label: string }) {
  return (
    <div
      class="progress"
      role="progressbar"
      aria-label={label}
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={Math.round(share * 100)}
    >
      <div style={{ '--fill': String(share) }} />
    </div>
  );
}

interface JobHeadProps {
  title: string;
  about: string;
  figure?: string;
}

/** Head of a card of work under way. */
export function JobHead({ title, about, figure }: JobHeadProps) {
  return (
    <div class="job-head line baseline small">
      <strong>{title}</strong>
      <span class="soft">{about}</span>
      {figure !== undefined && <span class="number">{figure}</span>}
    </div>
  );
}

export function Swatch({ color }: { color: string }) {
  return <span class="swatch" style={{ '--color': color }} />;
}

/** A name that is typed over; Enter or going elsewhere takes it, Escape gives it up. */
interface NameFieldProps {
  name: string;
  maxLength?: number;
  /** The typed name, without space around it; null: cancelled. */
  onFinish: (name: string | null) => void;
}

export function NameField({ name, maxLength = 80, onFinish }: NameFieldProps) {
  const finished = useRef(false);
  const finish = (result: string | null): void => {
    if (finished.current) return;
    finished.current = true;
    onFinish(result);
  };
  return (
    <input
      class="field name-field"
      aria-label="Name"
      maxLength={maxLength}
      ref={(input) => {
        if (!input || document.activeElement === input) return;
        input.value = name;
        input.focus();
        input.select();
      }}
      onClick={(event) => event.stopPropagation()}
      onBlur={(event) => finish(event.currentTarget.value.trim())}
      onKeyDown={(event) => {
        event.stopPropagation();
        if (event.key === 'Enter') finish(event.currentTarget.value.trim());
        if (event.key === 'Escape') finish(null);
      }}
    />
  );
}
