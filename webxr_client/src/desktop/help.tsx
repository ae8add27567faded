/** The keyboard and the mouse, on one page that can be searched. */
import { useEffect, useRef, useState } from 'preact/hooks';
import { BOX_KEYS } from '../boxes/keys';
import { COMMANDS } from './commands';
import { WALK_KEYS } from './keys';
import { found } from './command-search';
import { Button } from '../panels/parts/controls';
import { state } from '../store/state';
import { helpOpen } from '../panels/parts/popover';
import { beginTour } from '../panels/tour-steps';

const MOUSE = [
  ['Left drag', 'Use the tool'],
  ['Alt + left drag, middle drag', 'Turn the view'],
  ['Right drag', 'Move the view'],
  ['Wheel', 'Come closer, go away'],
  ['Drag on the ruler', 'Scrub through time'],
  ['Drag on the strips', 'Choose a range of frames'],
].map(([shown, what]) => ({ shown: shown!, what: what!, group: 'Mouse' }));

const GROUPS = ['Time', 'Tools', 'Labels', 'Edit', 'Review', 'View', 'Boxes', 'Mouse'] as const;

const ROWS = [...COMMANDS.filter(({ shown }) => shown !== ''), WALK_KEYS, ...BOX_KEYS, ...MOUSE];

export function Help() {
  return helpOpen.value ? <Opened /> : null;
}

function Opened() {
  const dialog = useRef<HTMLDialogElement>(null);
  const [query, setQuery] = useState('');
  useEffect(() => dialog.current?.showModal(), []);
  const rows = found(ROWS, query);
  return (
    <dialog
      ref={dialog}
      class="help"
      aria-label="Keyboard and mouse"
      onClose={() => (helpOpen.value = false)}
      onClick={(event) => event.target === dialog.current && dialog.current?.close()}
    >
      <div class="help-body">
        <header>
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
          {state.sequence.value && (
            <Button
              label="First steps"
              tip="A tour of five cards"
              kind="outlined"
              onClick={() => {
                // Closed first: what had the focus has it again, and after the tour once more.
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
        {rows.length === 0 && <p class="soft">Nothing has these words.</p>}
      </div>
    </dialog>
  );
}

interface KeyListProps {
  group: string;
  rows: readonly { readonly shown: string; readonly what: string }[];
}

function KeyList({ group, rows }: KeyListProps) {
  if (rows.length === 0) return null;
  return (
    <section>
      <h3>{group}</h3>
      <dl>
        {rows.map(({ shown, what }) => (
          <div key={what}>
            <dt>{what}</dt>
            <dd>
              <span class={group === 'Mouse' ? 'soft' : 'kbd'}>{shown}</span>
            </dd>
          </div>
        ))}
      </dl>
    </section>
  );
}
