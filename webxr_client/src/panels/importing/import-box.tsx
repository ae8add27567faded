/** Ways to import: files, a folder, a path on the server. */
import { signal } from '@preact/signals';
import { useState } from 'preact/hooks';
import { importEach, importPath } from '../../engine/recordings/importing';
import { Icon } from '../../common/icons';
import { Button, Check } from '../parts/controls';
import { PopoverButton } from '../parts/popover';
import { pickFiles } from './files';

const open = signal(false);

export function ImportButton() {
  return (
    <PopoverButton
      open={open}
      icon="import"
      button={{ label: 'Import', class: 'outlined' }}
      tip="Import recordings; files can also be dropped anywhere on the page"
      label="Import"
      class="import-popover"
    >
      <ImportBox onBegin={() => (open.value = false)} />
    </PopoverButton>
  );
}

/** `onBegin` is called before a dialog of the import opens. */
export function ImportBox({ onBegin }: { onBegin?: () => void }) {
  const [path, setPath] = useState('');
  const [each, setEach] = useState(false);
  const pick = (folder = false): void => {
    onBegin?.();
    pickFiles(folder);
  };
  const submit = (event: Event): void => {
    event.preventDefault();
    if (!path.trim()) return;
    onBegin?.();
    if (each) void importEach(path.trim());
    else void importPath(path.trim());
  };
  return (
    <section class="import-box stack" aria-label="Import">
      <div class="drop-hint stack">
        <Icon name="import" />
        <p>
          <strong class="title">Drop files or a folder here</strong>
          <span class="soft">PLY, PCD, LAS, LAZ, E57, NPZ, KITTI, XYZ, bags and more</span>
        </p>
        <div class="line">
          <Button label="Choose files" kind="primary" onClick={() => pick()} />
          <Button label="Choose a folder" kind="outlined" onClick={() => pick(true)} />
        </div>
      </div>
      <form class="path-form line" onSubmit={submit}>
        <label class="labelled grow small">
          <span class="soft">Or a path on the server</span>
          <input
            class="field"
            value={path}
            placeholder="/home/me/recordings/session-12"
            spellcheck={false}
            onInput={(event) => setPath(event.currentTarget.value)}
          />
        </label>
        <Button submit label="Import" kind="outlined" disabled={!path.trim()} />
      </form>
      <Check
        label="Import each file or folder in it as a recording"
        checked={each}
        onChange={setEach}
      />
      <p class="soft">
        In a terminal: <code>pointbrush import PATH…</code>
      </p>
    </section>
  );
}
