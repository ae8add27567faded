/** The clip box, which limits shown and painted points, in the tool bar and over the picture. */
import { signal } from '@preact/signals';
import { actions } from '../../store/actions';
import { clip } from '../../tools/clip';
import { canEdit, state } from '../../store/state';
import { Button, Check } from '../parts/controls';
import { PopoverButton } from '../parts/popover';
import { RadioGroup, type RadioOption } from '../parts/radio-group';

const open = signal(false);

type Kind = 'all' | 'box' | 'level' | 'across' | 'depth';

const KINDS: readonly RadioOption<Kind>[] = [
  { value: 'all', icon: 'eye', label: 'Everything', tip: 'Show all points' },
  { value: 'box', icon: 'box', label: 'Box', tip: 'Around the active object or the centre of the view' },
  { value: 'level', icon: 'slice', label: 'Level', tip: 'A slab between two heights' },
  { value: 'across', icon: 'slice', label: 'Left to right', tip: 'A slab that runs along the view' },
  { value: 'depth', icon: 'slice', label: 'In depth', tip: 'A slab across the view' },
]; // prettier-ignore
const SLABS = { level: 1, across: 0, depth: 2 } as const;
const OF_AXIS = ['across', 'level', 'depth'] as const;

function kindNow(): Kind {
  const { value } = clip;
  if (!value) return 'all';
  return value.slab === null ? 'box' : OF_AXIS[value.slab];
}

function choose(kind: Kind): void {
  if (kind === 'all') clip.value = null;
  else actions.view.clipTo(kind === 'box' ? null : SLABS[kind]);
}

/** In the tool bar's second row. */
export function ClipButton() {
  return (
    <PopoverButton open={open}
        icon="slice"
        tip="Clip: show and paint only points inside a box or slab"
        keys="Y"
        pressed={clip.value !== null} button={{ label: 'Clip' }} label="Clip" class="stack">
          <RadioGroup label="Shown" class="stack" options={KINDS} value={kindNow()} onChoose={choose} />
          {clip.value && (
            <Check
              label="Follow the active object"
              tip="The box follows the active label from frame to frame"
              checked={clip.value.follows}
              onChange={(follows) => clip.value && (clip.value = { ...clip.value, follows })}
            />
          )}
          <p class="soft">
            Drag the faces. <span class="kbd">Alt</span> + wheel or{' '}
            <span class="kbd">Page ↑ ↓</span> moves the box along its thinnest side.
          </p>
        </PopoverButton>
  ); // prettier-ignore
}

/** Sign over the picture while a clip box limits the points that a stroke reaches. */
export function ClipSign() {
  if (!clip.value || !state.sequence.value) return null;
  return (
    <div class="sign line" role="status">
      <span>
        {clip.value.slab === null ? 'Box' : 'Slab'} active: only points inside it are shown
        {canEdit.value && <strong> and painted</strong>}
      </span>
      <Button icon="close" small tip="Show everything" onClick={() => (clip.value = null)} />
    </div>
  );
}
