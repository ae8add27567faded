/** How the lasso is drawn. */
import { outlineKind, type OutlineKind } from '../tools/lasso';
import { Icon } from './icon';
import type { IconName } from './icons';

const KINDS: readonly (readonly [OutlineKind, IconName, string, string])[] = [
  ['free', 'lasso', 'Free', 'Draw the outline with the button held'],
  ['rectangle', 'rectangle', 'Rectangle', 'Drag from corner to corner'],
  ['polygon', 'polygon', 'Polygon', 'Click the corners; Enter, a double click or the first corner closes it, Backspace takes one back'],
]; // prettier-ignore

export function OutlineKinds() {
  return (
    <div class="segmented" role="radiogroup" aria-label="Outline">
      {KINDS.map(([kind, icon, label, tip]) => (
        <button
          key={kind}
          type="button"
          role="radio"
          class="button"
          aria-checked={outlineKind.value === kind}
          data-tip={tip}
          data-keys="O"
          onClick={() => (outlineKind.value = kind)}
        >
          <Icon name={icon} />
          {label}
        </button>
      ))}
    </div>
  );
}
