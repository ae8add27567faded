/** Frames laid over the one on screen: the switch, their number, and the frames of a stroke. */
import { signal } from '@preact/signals';
import { accumulation, leftOut, MOST_AROUND, placedFrames } from '../../cloud/points/accumulation';
import { canEdit, patch, state } from '../../store/state';
import { Button, Check, Slider } from '../parts/controls';
import { plural } from '../../common/format';
import { PopoverButton } from '../parts/popover';

const open = signal(false);

/** In the tool bar's second row. */
export function AccumulateButton() {
  const info = state.sequence.value;
  if (!info || info.large || info.frames < 2) return null;
  return (
    <PopoverButton
      open={open}
      icon="frames"
      tip="Overlay neighbouring frames and paint them together"
      pressed={accumulation.value.on}
      button={{ label: 'Frames' }}
      label="Neighbouring frames"
      class="stack"
    >
      <Around frames={info.frames} />
    </PopoverButton>
  );
}

function Around({ frames }: { frames: number }) {
  const { on, before, after } = accumulation.value;
  const most = Math.min(MOST_AROUND, frames - 1);
  const all = before >= most && after >= most;
  return (
    <>
      <Check
        label="Overlay neighbouring frames"
        tip="Aligned by the poses of the recording; tracked labels are aligned by their tracks"
        checked={on}
        onChange={(wanted) => patch(accumulation, { on: wanted })}
      />
      <Side
        name="Before"
        value={before}
        most={most}
        onInput={(n) => patch(accumulation, { before: n })}
      />
      <Side
        name="After"
        value={after}
        most={most}
        onInput={(n) => patch(accumulation, { after: n })}
      />
      <Button
        label="All frames"
        kind="outlined"
        pressed={all}
        onClick={() => patch(accumulation, { on: true, before: most, after: most })}
      />
    </>
  );
}

interface SideProps {
  name: string;
  value: number;
  most: number;
  onInput: (frames: number) => void;
}

function Side({ name, value, most, onInput }: SideProps) {
  const shown = Math.min(value, most);
  return (
    <Slider
      label={name}
      value={shown}
      min={0}
      max={most}
      step={1}
      tip={`Frames ${name.toLowerCase()} this one`}
      shown={plural(shown, 'frame')}
      onInput={(frames) => onInput(Math.round(frames))}
    />
  );
}

/** Sign over the picture while frames are laid over it, with the frames that a stroke paints. */
export function AccumulateSign() {
  if (!accumulation.value.on) return null;
  const shown = placedFrames.value.length;
  const left = leftOut.value;
  return (
    <div class="sign line" role="status">
      <span>
        {state.playing.value
          ? 'Frames are overlaid while playback is paused'
          : `${plural(shown + 1, 'frame')} overlaid`}
        {canEdit.value && shown > 0 && <strong> · strokes paint all of them</strong>}
        {left > 0 && ` · ${left} skipped: too many points`}
      </span>
      <Button
        icon="close"
        small
        tip="Show only this frame"
        onClick={() => patch(accumulation, { on: false })}
      />
    </div>
  );
}
