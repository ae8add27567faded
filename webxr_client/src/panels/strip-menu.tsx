/** On a strip of the timeline, with the right button: what can be done to its label there. */
import { signal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { actions } from '../actions';
import { canEdit, canReview, state, trackingJob } from '../state';
import { Icon } from './icon';
import type { IconName } from './icons';
import { Popover } from './popover';
import { frameRange, ordered } from './range';
import { cellWords } from './strip-words';

export interface StripPlace {
  readonly label: number;
  readonly frame: number;
  readonly x: number;
  readonly y: number;
}

export const stripPlace = signal<StripPlace | null>(null);
const close = (): void => {
  stripPlace.value = null;
};

interface Entry {
  readonly icon: IconName;
  readonly text: string;
  readonly disabled: boolean;
  readonly run: () => void;
}

export function StripMenu() {
  const anchor = useRef<HTMLSpanElement>(null);
  const place = stripPlace.value;
  if (!place) return null;
  const { x, y } = place;
  const label = state.palette.value.find(({ id }) => id === place.label);
  return (
    <>
      <span ref={anchor} class="menu-anchor" style={{ left: `${x}px`, top: `${y}px` }} />
      {label && (
        <Popover anchor={anchor} label={`${label.name}, frame ${place.frame}`} onClose={close}>
          <h2>
            {label.name}, frame {place.frame}
          </h2>
          <p class="soft strip-words">
            {cellWords(state.timeline.value.rows.get(label.id), place.frame)}
          </p>
          {entries(place, label.locked).map(({ icon, text, disabled, run }) => (
            <button
              key={text}
              type="button"
              class="menu-item"
              disabled={disabled}
              onClick={() => {
                close();
                run();
              }}
            >
              <Icon name={icon} /> {text}
            </button>
          ))}
        </Popover>
      )}
    </>
  );
}

/** The chosen stretch when the place lies in it, else the frame alone. */
function stretch(frame: number): readonly [number, number] {
  const range = frameRange.peek() && ordered(frameRange.peek()!);
  return range && frame >= range[0] && frame <= range[1] ? range : [frame, frame];
}

function entries({ label, frame }: StripPlace, locked: boolean): readonly Entry[] {
  const [from, to] = stretch(frame);
  const cannot = locked || !canEdit.value;
  const here = (state.timeline.value.rows.get(label)?.points[frame] ?? 0) > 0;
  const last = (state.sequence.value?.frames ?? 1) - 1;
  const busy = cannot || !here || trackingJob.value !== null;
  const track = (stop: number): void =>
    actions.track({ labels: [label], start: frame, stop, method: 'auto', overwrite: 'tracked' });
  const clears = from === to ? 'Clear here' : `Clear frames ${from} – ${to}`;
  return [
    { icon: 'target', text: 'Go there', disabled: false, run: () => actions.seek(frame) },
    { icon: 'track', text: 'Track on from here', disabled: busy || frame === last, run: () => track(last) },
    { icon: 'swap', text: 'Track back from here', disabled: busy || frame === 0, run: () => track(0) },
    { icon: 'check', text: 'Accept here', disabled: cannot || !canReview.value, run: () => void actions.acceptLabels([label], frame) },
    { icon: 'layers', text: 'Copy from the frame before', disabled: cannot || frame === 0, run: () => void actions.copyLabels([label], frame - 1, frame) },
    { icon: 'trash', text: clears, disabled: cannot, run: () => void actions.clearLabels([label], from, to) },
  ]; // prettier-ignore
}
