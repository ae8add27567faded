/** Frames: their states and notes, and the report. */
import { useEffect } from 'preact/hooks';
import { sequencePath } from '../engine/recordings/recordings';
import { apiUrl } from '../net/rest';
import { Button } from '../panels/parts/controls';
import { canEdit, canReview, state } from '../store/state';
import { framesOf, notesOf, type ReviewState, standingOf, STATE_WORDS, STATES } from './model';
import { Field } from '../panels/parts/fields';
import { Entry, NoteField } from './parts';
import { pointing, visit } from './places';
import { draft, judge, overview } from './review';

/** The states that a frame can get: text, and the key for the frame on screen. */
const VERBS: readonly (readonly [ReviewState, string, string?])[] = [
  ['accepted', 'Mark as checked', 'Ctrl Enter'],
  ['rejected', 'Needs correction', 'Ctrl Backspace'],
  ['review', 'Ready to check'],
  ['open', 'Reopen'],
];

export function Frames() {
  useEffect(() => () => void (pointing.value = null), []);
  return (
    <>
      <Strip />
      <FrameStanding />
      <Judge />
      <Notes />
      <Report />
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
      <ul class="line spread small">
        {STATES.map((kind) => (
          <li key={kind} data-state={kind}>
            <span class="number of-state">{counts?.[kind] ?? '–'}</span> {STATE_WORDS[kind]}
          </li>
        ))}
      </ul>
    </>
  );
}

function FrameStanding() {
  const frame = state.frame.value;
  const standing = standingOf(overview.value, frame);
  return (
    <p>
      Frame {frame}:{' '}
      <strong class="of-state" data-state={standing?.state ?? 'open'}>
        {STATE_WORDS[standing?.state ?? 'open']}
      </strong>
      {standing?.by && <span class="soft"> · {standing.by}</span>}
      {standing?.changed && (
        <span data-state="review" class="of-state">
          {' '}
          · changed since
        </span>
      )}
      {standing?.assignee && <span class="soft"> · assigned to {standing.assignee}</span>}
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
    <form class="work-form stack" onSubmit={(event) => event.preventDefault()}>
      <div class="halves" role="group" aria-label="State">
        {VERBS.map(([kind, words, keys]) => (
          <Button
            key={kind}
            class={`verdict-${kind}`}
            label={words}
            kind="outlined"
            disabled={!(kind === 'accepted' || kind === 'rejected' ? canReview : canEdit).value}
            keys={keys}
            onClick={() => void judge(kind)}
          />
        ))}
      </div>
      <FrameRange first={first ?? frame} last={last ?? frame} onChange={set} />
      <NoteField note={note} place={place} onChange={set} />
    </form>
  );
}

function Notes() {
  const notes = notesOf(overview.value);
  const nameOf = (label: number | null) => state.palette.value.find(({ id }) => id === label)?.name;
  if (notes.length === 0) return null;
  return (
    <>
      <h3>Notes</h3>
      <ul class="entries">
        {notes.map(({ first, last, label, place, note, state: kind, by }) => (
          <Entry
            key={`${label}-${first}`}
            icon={place ? 'target' : 'pencil'}
            about={[nameOf(label), first === null ? 'the label' : framesOf({ first, last }), STATE_WORDS[kind], by].filter(Boolean).join(' · ')}
            onClick={() => visit(first, place)}
          >
            {note}
          </Entry>
        ))}
      </ul>
    </>
  ); // prettier-ignore
}

interface FrameRangeProps {
  first: number;
  last: number;
  onChange: (range: { first: number; last: number }) => void;
}

/** Two numbers: the first and the last frame. */
export function FrameRange({ first, last, onChange }: FrameRangeProps) {
  const most = (state.sequence.value?.frames ?? 1) - 1;
  const field = (label: string, value: number, change: (value: number) => void) => (
    <Field
      label={label}
      type="number"
      min={0}
      max={most}
      value={value}
      onChange={({ currentTarget: { valueAsNumber: typed } }) =>
        change(Number.isNaN(typed) ? value : Math.min(most, Math.max(0, Math.round(typed))))
      }
    />
  );
  return (
    <div class="halves">
      {field('From frame', first, (value) =>
        onChange({ first: value, last: Math.max(value, last) }),
      )}
      {field('to', last, (value) => onChange({ first: Math.min(first, value), last: value }))}
    </div>
  );
}

function Report() {
  const base = apiUrl(`${sequencePath(state.sequence.value?.id ?? '')}/report`);
  return (
    <p class="line wrap small">
      <a class="button outlined" href={base} target="_blank" rel="noreferrer">
        Report
      </a>
      <span class="soft">as tables:</span>
      {['frames', 'labels', 'people'].map((table) => (
        <a key={table} href={`${base}?format=csv&table=${table}`} download>
          {table}
        </a>
      ))}
    </p>
  );
}
