/** Other people here, and the state of the server. */
import { signal } from '@preact/signals';
import { state, type Person } from '../store/state';
import { inkOn } from '../common/colors';

const SHOWN = 4;

/** Id of the person that the camera follows, or null. */
export const following = signal<string | null>(null);

export function People() {
  const people = state.people.value;
  if (people.length === 0) return null;
  return (
    <ul class="people" aria-label="People present">
      {people.slice(0, SHOWN).map((person) => (
        <PersonBadge key={person.viewer} person={person} />
      ))}
      {people.length > SHOWN && (
        <li class="person more" data-tip={people.slice(SHOWN).map(nameOf).join(', ')}>
          +{people.length - SHOWN}
        </li>
      )}
    </ul>
  );
}

function PersonBadge({ person }: { person: Person }) {
  const where = `on frame ${person.frame}${person.head ? ', in a headset' : ''}`;
  const on = following.value === person.viewer;
  const can = person.head ? (on ? ': stop following' : ': follow their view') : '';
  return (
    <li>
      <button
        type="button"
        class="person"
        style={{ '--color': person.color, '--ink': inkOn(person.color) }}
        aria-pressed={on}
        aria-label={`${nameOf(person)}, ${where}`}
        data-tip={`${nameOf(person)}, ${where}${can}`}
        onClick={() => (following.value = on || !person.head ? null : person.viewer)}
      >
        {initials(nameOf(person))}
      </button>
    </li>
  );
}

function nameOf(person: Person): string {
  return person.name || 'Unnamed';
}

function initials(name: string): string {
  const words = name.trim().split(/\s+/);
  return words
    .slice(0, 2)
    .map((word) => String.fromCodePoint(word.codePointAt(0) ?? 32))
    .join('')
    .toUpperCase();
}

const WORDS = {
  connecting: 'Connecting',
  online: 'Saved',
  offline: 'Offline',
  refused: 'Refused',
} as const;

export function ConnectionStatus() {
  const connection = state.connection.value;
  const pending = state.pending.value;
  const saving = connection.state === 'online' && pending > 0;
  const idle = connection.state === 'online' && !state.sequence.value;
  const word = saving ? 'Saving' : idle ? 'Connected' : WORDS[connection.state];
  const tip =
    connection.detail ||
    (saving
      ? 'Sending strokes to the server'
      : idle
        ? 'Connected to the server'
        : 'All strokes are stored');
  return (
    <span
      class="connection"
      role="status"
      data-state={saving ? 'saving' : connection.state}
      data-tip={connection.state === 'connecting' ? 'Connecting to the server' : tip}
    >
      <span class="dot" />
      <span class="button-label">{word}</span>
    </span>
  );
}
