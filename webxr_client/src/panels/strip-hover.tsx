/** Beside the pointer over the timeline: a picture of the frame, and what the strip says there. */
import { signal } from '@preact/signals';
import { apiUrl } from '../net/rest';
import { state } from '../state';
import { clock } from './format';
import { cellWords } from './strip-words';

export interface StripHover {
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
    <div class="strip-card" style={{ left: `${left}px`, bottom: `${at.bottom}px` }}>
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
