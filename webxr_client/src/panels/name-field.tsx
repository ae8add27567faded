/** A name that is typed over; Enter or going elsewhere takes it, Escape gives it up. */
import { useRef } from 'preact/hooks';

interface NameFieldProps {
  name: string;
  maxLength?: number;
  /** The typed name, without space around it; null: given up. */
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
