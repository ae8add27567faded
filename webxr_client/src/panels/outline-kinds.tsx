/** Kinds of lasso. */
import { outlineKind, type OutlineKind } from '../tools/lasso';
import { RadioGroup, type RadioOption } from './radio-group';

const KINDS: readonly RadioOption<OutlineKind>[] = [
  { value: 'free', icon: 'lasso', label: 'Free', tip: 'Draw the outline with the button held', keys: 'O' },
  { value: 'rectangle', icon: 'rectangle', label: 'Rectangle', tip: 'Drag from corner to corner', keys: 'O' },
  { value: 'polygon', icon: 'polygon', label: 'Polygon', tip: 'Click the corners; Enter, a double click or the first corner closes it, Backspace takes one back', keys: 'O' },
]; // prettier-ignore

export function OutlineKinds() {
  return (
    <RadioGroup
      label="Outline"
      class="segmented"
      options={KINDS}
      value={outlineKind.value}
      onChoose={(kind) => (outlineKind.value = kind)}
    />
  );
}
