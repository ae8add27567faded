/** Two numbers that say from which frame to which. */
import { state } from '../state';

export interface FrameRangeProps {
  first: number;
  last: number;
  onChange: (range: { first: number; last: number }) => void;
}

export function FrameRange({ first, last, onChange }: FrameRangeProps) {
  const most = (state.sequence.value?.frames ?? 1) - 1;
  const within = (text: string, otherwise: number): number => {
    const value = Math.round(Number(text));
    return text && Number.isFinite(value) ? Math.min(most, Math.max(0, value)) : otherwise;
  };
  const field = (name: string, value: number, change: (value: number) => void) => (
    <label>
      {name}
      <input
        type="number"
        min={0}
        max={most}
        value={value}
        onChange={(event) => change(within(event.currentTarget.value, value))}
        onKeyDown={(event) => event.stopPropagation()}
      />
    </label>
  );
  return (
    <div class="frame-range">
      {field('From frame', first, (value) =>
        onChange({ first: value, last: Math.max(value, last) }),
      )}
      {field('to', last, (value) => onChange({ first: Math.min(first, value), last: value }))}
    </div>
  );
}
