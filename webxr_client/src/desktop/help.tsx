/** The keyboard and the mouse, on one page that can be searched. */
import { signal } from '@preact/signals';
import { useState } from 'preact/hooks';
import { BOX_KEYS } from '../boxes/keys';
import { COMMANDS } from './commands';
import { keyName } from './keyboard';
import { type KeyBinding, WALK_KEYS } from './keys';
import { isChangeable, isFree, shownOf } from './shortcuts';
import { resetKeys, setKey } from '../store/own-keys';
import { found } from './command-search';
import { Button } from '../panels/parts/controls';
import { state } from '../store/state';
import { useModal } from '../panels/parts/modal';
import { helpOpen } from '../panels/parts/popover';
import { beginTour } from '../panels/tour-steps';

const MOUSE = [
  ['Left drag', 'Use the tool'],
  ['Alt + left drag, middle drag', 'Turn the view'],
  ['Right drag', 'Move the view'],
  ['Wheel', 'Zoom in, zoom out'],
  ['Drag on the ruler', 'Scrub through time'],
  ['Drag on the strips', 'Choose a range of frames'],
].map(([shown, what]) => ({ shown: shown!, what: what!, group: 'Mouse' }));

const GROUPS = ['Time', 'Tools', 'Labels', 'Edit', 'Work', 'View', 'Boxes', 'Mouse'] as const;

interface HelpRow {
  readonly shown: string;
  readonly what: string;
  readonly group: string;
  /** The command, if its key can be changed. */
  readonly binding?: KeyBinding;
}

/** The text of the command that waits for its new key, and whether keys are being changed. */
const waiting = signal<string | null>(null);
const changing = signal(false);

/** Commands with a key; all that may have one while keys are changed. */
function rowsNow(): readonly HelpRow[] {
  const all = changing.value;
  const rows = COMMANDS.map((binding): HelpRow => {
    const { what, group } = binding;
    return {
      shown: shownOf(binding),
      what,
      group,
      ...(all && isChangeable(binding) && { binding }),
    };
  });
  const listed = rows.filter(({ shown, binding }) => shown !== '' || binding);
  return [...listed, WALK_KEYS, ...BOX_KEYS, ...MOUSE];
}

export function Help() {
  return helpOpen.value ? <Opened /> : null;
}

function Opened() {
  const dialog = useModal();
  const [query, setQuery] = useState('');
  const rows = found(rowsNow(), query);
  return (
    <dialog
      ref={dialog}
      class="help wide"
      aria-label="Keyboard and mouse"
      onClose={() => (helpOpen.value = false)}
      onClick={(event) => event.target === dialog.current && dialog.current?.close()}
    >
      <div class="help-body">
        <header class="line spread wrap">
          <h2>Keyboard and mouse</h2>
          <input
            class="field"
            type="search"
            aria-label="Search"
            placeholder="Search"
            autofocus
            value={query}
            onInput={(event) => setQuery(event.currentTarget.value)}
          />
          <Button
            label={changing.value ? 'Done' : 'Change keys'}
            tip="Choose your own keys"
            kind="outlined"
            onClick={() => (changing.value = !changing.value)}
          />
          {changing.value && (
            <Button label="Reset" tip="Reset all keys to the defaults" onClick={resetKeys} />
          )}
          {state.sequence.value && !changing.value && (
            <Button
              label="First steps"
              tip="A tour of five cards"
              kind="outlined"
              onClick={() => {
                // Closed first, so that the tour returns the focus to the element that had it before.
                dialog.current?.close();
                beginTour();
              }}
            />
          )}
          <Button icon="close" tip="Close" keys="Esc" onClick={() => dialog.current?.close()} />
        </header>
        <div class="help-columns">
          {GROUPS.map((group) => (
            <KeyList key={group} group={group} rows={rows.filter((row) => row.group === group)} />
          ))}
        </div>
        {rows.length === 0 && <p class="soft">No entry matches.</p>}
      </div>
    </dialog>
  );
}

interface KeyListProps {
  group: string;
  rows: readonly HelpRow[];
}

function KeyList({ group, rows }: KeyListProps) {
  if (rows.length === 0) return null;
  return (
    <section>
      <h3>{group}</h3>
      <dl>
        {rows.map(({ shown, what, binding }) => (
          <div key={what} class="line spread">
            <dt>{what}</dt>
            <dd>
              {binding ? (
                <KeyButton what={what} shown={shown} />
              ) : (
                <span class={group === 'Mouse' ? 'soft' : 'kbd'}>{shown}</span>
              )}
            </dd>
          </div>
        ))}
      </dl>
    </section>
  );
}

/** A key that can be changed: Backspace restores the default, Escape cancels. */
function KeyButton({ what, shown }: { what: string; shown: string }) {
  const waits = waiting.value === what;
  const press = (event: KeyboardEvent): void => {
    if (!waits || event.key === 'Tab') return;
    event.preventDefault();
    event.stopPropagation();
    const key = keyName(event);
    if (key === 'backspace' || isFree(key)) setKey(what, key === 'backspace' ? null : key);
    if (key === 'escape' || key === 'backspace' || isFree(key)) waiting.value = null;
  };
  return (
    <button
      type="button"
      class="kbd key-button"
      aria-label={`Key of ${what}: ${shown || 'none'}`}
      onClick={() => (waiting.value = what)}
      onKeyDown={press}
      onBlur={() => (waiting.value = null)}
    >
      {waits ? 'Press a key…' : shown || 'none'}
    </button>
  );
}
