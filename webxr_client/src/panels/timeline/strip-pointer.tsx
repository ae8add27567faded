/** State and actions of the cell under the pointer on a strip of the timeline. */
import { signal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { actions } from '../../store/actions';
import { apiUrl } from '../../net/rest';
import { canEdit, canReview, state, type TimelineRow, trackingJob } from '../../store/state';
import { clock, plural } from '../../common/format';
import { type IconName } from '../../common/icons';
import { MenuItem, Popover } from '../parts/popover';
import { frameRange, ordered } from '../../store/range';
import { cellKind, type CellKind, hasPoints } from '../../store/cells';

const KIND_WORDS: Readonly<Record<CellKind, string>> = {
  none: 'not labelled',
  painted: 'painted',
  tracked: 'tracked',
  occluded: 'tracked, occluded',
  doubtful: 'tracked, doubtful',
  lost: 'lost',
};

function cellWords(row: TimelineRow | undefined, frame: number): string {
  if (!row) return KIND_WORDS.none;
  const kind = cellKind(row, frame);
  const words = [KIND_WORDS[kind]];
  const confidence = row.confidence[frame] ?? Number.NaN;
  if (kind !== 'painted' && kind !== 'none' && !Number.isNaN(confidence))
    words.push(`${Math.round(confidence * 100)} % confidence`);
  const points = row.points[frame] ?? 0;
  if (points > 0) words.push(plural(points, 'point'));
  return words.join(' · ');
}

/** Card beside the pointer over the timeline: a picture of the frame, and the cell's state. */
interface StripHover {
  readonly frame: number;
  /** The label of the strip; null on the ruler. */
  readonly label: number | null;
  /** Pixels from the left and bottom edge of the window. */
  readonly x: number;
  readonly bottom: number;
}

export const stripHover = signal<StripHover | null>(null);

const WIDTH = 176;

export function StripCard() {
  const at = stripHover.value;
  const info = state.sequence.value;
  if (!at || !info) return null;
  const label = state.palette.value.find(({ id }) => id === at.label);
  const left = Math.max(8, Math.min(at.x - WIDTH / 2, innerWidth - WIDTH - 8));
  const path = `sequences/${encodeURIComponent(info.id)}/frames/${at.frame}/thumbnail`;
  return (
    <div
      class="strip-card card stack small"
      style={{ left: `${left}px`, bottom: `${at.bottom}px` }}
    >
      <img src={`${apiUrl(path)}?of=${info.identity}`} alt="" width={160} height={90} />
      <span class="number">
        Frame {at.frame}
        {info.fps > 0 && <span class="faint"> {clock(at.frame / info.fps)}</span>}
      </span>
      {label && (
        <span class="name">
          <span class="swatch" style={{ '--color': label.color }} /> {label.name}
        </span>
      )}
      {label && (
        <span class="soft">{cellWords(state.timeline.value.rows.get(label.id), at.frame)}</span>
      )}
    </div>
  );
}

/** Menu of the right button on a strip of the timeline: actions on its label there. */
interface StripPlace {
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
          <p class="soft empty">
            {cellWords(state.timeline.value.rows.get(label.id), place.frame)}
          </p>
          {entries(place, label.locked).map(({ icon, text, disabled, run }) => (
            <MenuItem key={text} icon={icon} label={text} disabled={disabled} onClick={run} />
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
  const last = (state.sequence.value?.frames ?? 1) - 1;
  const isIn = hasPoints(state.timeline.value.rows.get(label), frame);
  const busy = cannot || !isIn || trackingJob.value !== null;
  const track = (stop: number): void =>
    actions.tracking.track({ labels: [label], start: frame, stop });
  const clears = from === to ? 'Clear here' : `Clear frames ${from} – ${to}`;
  return [
    { icon: 'target', text: 'Go there', disabled: false, run: () => actions.time.seek(frame) },
    { icon: 'track', text: 'Track forward from here', disabled: busy || frame === last, run: () => track(last) },
    { icon: 'swap', text: 'Track backward from here', disabled: busy || frame === 0, run: () => track(0) },
    { icon: 'check', text: 'Confirm here', disabled: cannot || !canReview.value, run: () => void actions.labels.acceptLabels([label], frame) },
    { icon: 'layers', text: 'Copy from the previous frame', disabled: cannot || frame === 0, run: () => void actions.labels.copyLabels([label], frame - 1, frame) },
    { icon: 'trash', text: clears, disabled: cannot, run: () => void actions.labels.clearLabels([label], from, to) },
  ]; // prettier-ignore
}
