/** The colour set, and any other colour. */
import type { RefObject } from 'preact';
import { actions } from '../actions';
import type { Label } from '../protocol/messages';
import { state } from '../state';
import { LABEL_COLORS } from './colors';
import { Popover } from './popover';

interface ColorPickerProps {
  label: Label;
  anchor: RefObject<HTMLElement | null>;
  onClose: () => void;
}

export function ColorPicker({ label, anchor, onClose }: ColorPickerProps) {
  const taken = new Set(
    state.palette.value.filter((other) => other.id !== label.id).map((other) => other.color),
  );
  const choose = (color: string): void => {
    onClose();
    if (color !== label.color) void actions.recolorLabel(label.id, color);
  };
  return (
    <Popover anchor={anchor} label={`Colour of ${label.name}`} onClose={onClose}>
      <div class="color-grid">
        {LABEL_COLORS.map((color) => (
          <button
            key={color}
            type="button"
            class="color-choice"
            style={{ '--color': color }}
            aria-label={color}
            aria-pressed={color === label.color}
            data-taken={taken.has(color) || undefined}
            data-tip={taken.has(color) ? 'Another label has this colour' : undefined}
            onClick={() => choose(color)}
          />
        ))}
      </div>
      <label class="row">
        <span>Other</span>
        <input
          type="color"
          value={label.color}
          onChange={(event) => choose(event.currentTarget.value)}
        />
      </label>
    </Popover>
  );
}
