/** States of frames: what they are, who said so, and what one says oneself. */
import { useEffect } from 'preact/hooks';
import { Button } from '../panels/parts/controls';
import { plural } from '../common/format';
import { Icon } from '../common/icons';
import { canEdit, canReview, state } from '../store/state';
import {
  framesOf,
  type LabelProgress,
  notesOf,
  progressOf,
  type ReviewState,
  type Standing,
  standingOf,
  STATE_WORDS,
  STATES,
} from './model';
import { Pin } from './pin';
import { draft, judge, overview, pointing, visit } from './store';

const VERBS: Readonly<Record<ReviewState, string>> = {
  open: 'Open again',
  review: 'Hand in',
  accepted: 'Accept',
  rejected: 'Reject',
};

const KEYS: Readonly<Partial<Record<ReviewState, string>>> = {
  accepted: 'Ctrl Enter',
  rejected: 'Ctrl Backspace',
};

export function FrameStates() {
  useEffect(() => () => void (pointing.value = null), []);
  return (
    <>
      <Strip />
      <Here />
      <Judge />
      <Notes />
      <ByLabel />
    </>
  );
}

/** All frames in a line, coloured by their states; a click goes there. */
function Strip() {
  const frames = state.sequence.value?.frames ?? 1;
  const { counts, frames: runs } = overview.value ?? { counts: null, frames: [] };
  const seek = (event: MouseEvent): void => {
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    visit(Math.floor(((event.clientX - box.left) / box.width) * frames), null);
  };
  return (
    <>
      <div class="state-strip" aria-hidden="true" onClick={seek}>
        {runs
          .filter(({ label }) => label === null)
          .map(({ first, last, state: kind }) => (
            <span
              key={first}
              data-state={kind}
              style={{
                left: `${(100 * first!) / frames}%`,
                width: `${(100 * (last! - first! + 1)) / frames}%`,
              }}
            />
          ))}
        <span class="head" style={{ left: `${(100 * (state.frame.value + 0.5)) / frames}%` }} />
      </div>
      <ul class="state-counts">
        {STATES.map((kind) => (
          <li key={kind} data-state={kind}>
            <span class="number">{counts?.[kind] ?? '–'}</span> {STATE_WORDS[kind]}
          </li>
        ))}
      </ul>
    </>
  );
}

function Here() {
  const frame = state.frame.value;
  const here = standingOf(overview.value, frame);
  return (
    <p class="review-here">
      Frame {frame} is{' '}
      <strong data-state={here?.state ?? 'open'}>{STATE_WORDS[here?.state ?? 'open']}</strong>
      {here?.by && <span class="soft"> · {here.by}</span>}
      {here?.changed && <span class="warn"> · changed since</span>}
      {here?.assignee && <span class="soft"> · assigned to {here.assignee}</span>}
    </p>
  );
}

function Judge() {
  const frame = state.frame.value;
  const { note, place, first, last } = draft.value;
  const set = (patch: Partial<typeof draft.value>): void => {
    draft.value = { ...draft.peek(), ...patch };
  };
  return (
    <form class="review-form" onSubmit={(event) => event.preventDefault()}>
      <div class="verdicts" role="group" aria-label="State">
        {STATES.map((kind) => (
          <Button
            key={kind}
            class={`verdict-${kind}`}
            label={VERBS[kind]}
            kind="outlined"
            disabled={!(kind === 'accepted' || kind === 'rejected' ? canReview : canEdit).value}
            keys={KEYS[kind]}
            onClick={() => void judge(kind)}
          />
        ))}
      </div>
      <FrameRange first={first ?? frame} last={last ?? frame} onChange={set} />
      <label>
        Note
        <textarea
          rows={3}
          maxLength={2000}
          value={note}
          placeholder="Describe the correction"
          onInput={(event) => set({ note: event.currentTarget.value })}
          onKeyDown={(event) => event.stopPropagation()}
        />
      </label>
      <Pin place={place} onPin={(at) => set({ place: at })} />
    </form>
  );
}

function Notes() {
  const notes = notesOf(overview.value);
  if (notes.length === 0) return null;
  return (
    <>
      <h3>Notes</h3>
      <ul class="findings">
        {notes.map((each) => (
          <li key={`${each.label}-${each.first}`}>
            <NoteRow standing={each} />
          </li>
        ))}
      </ul>
    </>
  );
}

function NoteRow({ standing }: { standing: Standing }) {
  const label = state.palette.value.find(({ id }) => id === standing.label)?.name;
  const about = standing.first === null ? 'the label' : framesOf(standing);
  return (
    <button type="button" class="menu-item" onClick={() => visit(standing.first, standing.place)}>
      <Icon name={standing.place ? 'target' : 'pencil'} />
      <span class="what">
        {standing.note}
        <span class="soft">
          {[label, about, STATE_WORDS[standing.state], standing.by].filter(Boolean).join(' · ')}
        </span>
      </span>
    </button>
  );
}

const PARTS = ['painted', 'tracked', 'doubtful'] as const;

/** Frames of each label: painted or confirmed, tracked, doubtful; labels without any in one line. */
function ByLabel() {
  const frames = state.sequence.value?.frames ?? 1;
  const palette = state.palette.value;
  const found = progressOf(state.timeline.value.rows);
  const empty = palette.length - found.length;
  return (
    <>
      <h3>Frames by label</h3>
      <ul class="label-progress">
        {found.map((one) => (
          <li key={one.label}>
            <span class="name">{palette.find(({ id }) => id === one.label)?.name}</span>
            <span
              class="parts"
              role="img"
              aria-label={wordsOf(one, frames)}
              data-tip={wordsOf(one, frames)}
            >
              {PARTS.map((part) => (
                <span
                  key={part}
                  data-part={part}
                  style={{ width: `${(100 * one[part]) / frames}%` }}
                />
              ))}
            </span>
          </li>
        ))}
      </ul>
      {empty > 0 && <p class="soft">{plural(empty, 'label')} without points</p>}
    </>
  );
}

function wordsOf({ painted, tracked, doubtful }: LabelProgress, frames: number): string {
  const left = frames - painted - tracked - doubtful;
  return `${painted} painted, ${tracked} tracked, ${doubtful} doubtful, ${left} without points`;
}

/** Two numbers that say from which frame to which. */
interface FrameRangeProps {
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
