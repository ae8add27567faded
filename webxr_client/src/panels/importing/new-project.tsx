/** A form for a new project. */
import { useState } from 'preact/hooks';
import { createProject, settled } from '../../engine/recordings/projects';
import { plural } from '../../common/format';
import type { SequenceSummary } from '../../store/state';
import { Button, Check } from '../parts/controls';
import { Row } from '../parts/fields';
import { useModal } from '../parts/modal';

interface NewProjectProps {
  /** Recordings that a search has found, which can move into it. */
  rows: readonly SequenceSummary[];
}

export function NewProject(props: NewProjectProps) {
  const [open, setOpen] = useState(false);
  return (
    <>
      <Button icon="plus" label="New project" onClick={() => setOpen(true)} />
      {open && <Form {...props} onClose={() => setOpen(false)} />}
    </>
  );
}

function Form({ rows, onClose }: NewProjectProps & { onClose: () => void }) {
  const dialog = useModal();
  const [name, setName] = useState('');
  const [moving, setMoving] = useState(false);
  const create = async (settings = false): Promise<void> => {
    const made = await createProject(name.trim(), moving ? rows.map(({ id }) => id) : []);
    if (made === null) return;
    onClose();
    if (settings) settled.value = made;
  };
  const submit = (event: Event): void => {
    event.preventDefault();
    void create();
  };
  return (
    <dialog ref={dialog} class="import" aria-label="New project" onClose={onClose}>
      <form onSubmit={submit}>
        <header class="line spread">
          <h2>New project</h2>
        </header>
        <div class="import-body stack">
          <p class="soft">
            A project is a group of recordings with people, categories and tasks of its own.
          </p>
          <Row label="Name">
            <input
              class="field"
              data-autofocus
              required
              maxLength={200}
              value={name}
              onInput={(event) => setName(event.currentTarget.value)}
            />
          </Row>
          {rows.length > 0 && (
            <Check
              label={`Move the ${plural(rows.length, 'recording')} of the search into it`}
              checked={moving}
              onChange={setMoving}
            />
          )}
        </div>
        <footer class="line">
          <Button label="Cancel" onClick={onClose} />
          <Button
            label="Create and set up…"
            tip="Create it, and choose its people, categories and tasks"
            kind="outlined"
            disabled={!name.trim()}
            onClick={() => void create(true)}
          />
          <Button submit label="Create" kind="primary" disabled={!name.trim()} />
        </footer>
      </form>
    </dialog>
  );
}
