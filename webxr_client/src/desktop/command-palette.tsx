/** Search of all commands by text: Ctrl K. */
import { useEffect, useMemo, useState } from 'preact/hooks';
import {
  commandsNow,
  found,
  frameCommand,
  lastFirst,
  noteUsed,
  type Command,
} from './command-search';
import { useModal } from '../panels/parts/modal';
import { commandsOpen } from '../panels/parts/popover';
import { nextIndex } from '../panels/parts/radio-group';

/** Commands that are listed at once. */
const MOST = 100;

export function CommandPalette() {
  return commandsOpen.value ? <Opened /> : null;
}

function Opened() {
  const dialog = useModal();
  const [query, setQuery] = useState('');
  const [at, setAt] = useState(0);
  const all = useMemo(() => lastFirst(commandsNow()), []);
  const shown = [...frameCommand(query), ...found(all, query)].slice(0, MOST);
  useEffect(() => {
    document.getElementById(optionId(at))?.scrollIntoView({ block: 'nearest' });
  }, [at]);
  const run = (command: Command | undefined): void => {
    if (!command) return;
    // The focus is returned first, because the command may open a dialog that takes it.
    dialog.current?.close();
    noteUsed(command);
    command.run();
  };
  const keys = (event: KeyboardEvent): void => {
    event.stopPropagation();
    if (event.key === 'Enter') run(shown[at]);
    const up = event.key === 'ArrowUp' || event.key === 'ArrowDown';
    const to = up ? nextIndex(event.key, at, shown.length) : null;
    if (to !== null) setAt(to);
    if (to !== null || event.key === 'Enter') event.preventDefault();
  };
  return (
    <dialog
      ref={dialog}
      class="commands"
      aria-label="All commands"
      onClose={() => (commandsOpen.value = false)}
      onClick={(event) => event.target === dialog.current && dialog.current?.close()}
    >
      <input
        class="field"
        role="combobox"
        aria-label="Search commands"
        aria-expanded="true"
        aria-controls="command-list"
        aria-activedescendant={shown.length > 0 ? optionId(at) : undefined}
        placeholder="A command, a label, a recording or a frame"
        spellcheck={false}
        autocomplete="off"
        value={query}
        onInput={(event) => {
          setQuery(event.currentTarget.value);
          setAt(0);
        }}
        onKeyDown={keys}
      />
      <ul id="command-list" role="listbox" aria-label="Commands">
        {shown.map((command, index) => (
          <li
            key={`${command.group} ${command.what}`}
            id={optionId(index)}
            role="option"
            class="command line"
            aria-selected={index === at}
            onPointerMove={() => setAt(index)}
            onClick={() => run(command)}
          >
            <span class="name grow">{command.what}</span>
            <span class="faint">{command.group}</span>
            {command.shown && <span class="kbd">{command.shown}</span>}
          </li>
        ))}
      </ul>
      {shown.length === 0 && <p class="soft empty">No command matches.</p>}
    </dialog>
  );
}

function optionId(index: number): string {
  return `command-${index}`;
}
