/** Snapshots of a project's labels: named, compared by label and frame, exported. */
import type { Difference, Snapshot } from '../protocol/values';
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { day, plural, shortCount } from '../common/format';
import { exportFormats, groupFormats } from '../engine/recordings/export-formats';
import { exportSequence, loadExportFormats, rowOf } from '../engine/recordings/recordings';
import { Button } from '../panels/parts/controls';
import { canManage, state } from '../store/state';
import { Choice, Field, Table } from '../panels/parts/fields';
import { Entry } from './parts';
import { goTo } from './places';
import * as versions from './snapshots';
import { project } from './store';

const name = signal('');

export function Versions() {
  const of = project.value?.id;
  useEffect(() => void versions.loadSnapshots(), [of]);
  useEffect(() => void loadExportFormats(), []);
  return (
    <>
      {canManage.value && <Name />}
      {versions.snapshots.value.length === 0 && <p class="soft empty">No snapshots yet.</p>}
      <ul class="entries">
        {versions.snapshots.value.map((each) => {
          const isCompared = each.id === versions.compared.value?.id;
          const held = plural(Object.keys(each.recordings).length, 'recording');
          return (
            <Entry
              key={each.id}
              current={isCompared}
              about={`${day(each.created)} · ${each.author} · ${held}`}
              onClick={() => void versions.compare(each)}
              actions={isCompared && <Actions snapshot={each} />}
            >
              {each.name}
            </Entry>
          );
        })}
      </ul>
      {versions.compared.value && <Compared snapshot={versions.compared.value} />}
    </>
  );
}

function Name() {
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (await versions.createSnapshot(name.peek().trim())) name.value = '';
  };
  return (
    <form class="work-form stack" onSubmit={(event) => void submit(event)}>
      <Field
        label="Name of the snapshot"
        maxLength={200}
        value={name.value}
        onInput={(event) => (name.value = event.currentTarget.value)}
      />
      <button type="submit" class="button primary" disabled={!name.value.trim()}>
        Make a snapshot
      </button>
    </form>
  );
}

function Actions({ snapshot }: { snapshot: Snapshot }) {
  const held = (state.sequence.value?.id ?? '') in snapshot.recordings;
  return (
    <div class="entry-actions line">
      <select
        class="field grow"
        aria-label="Export this recording from the snapshot"
        value=""
        disabled={!held}
        onChange={({ currentTarget }) => {
          void exportSequence(currentTarget.value, '', '', snapshot.id);
          currentTarget.value = '';
        }}
      >
        <option value="">Export from this snapshot as…</option>
        {groupFormats(exportFormats.value, true).map(({ purpose, formats }) => (
          <optgroup key={purpose} label={purpose}>
            {formats.map(({ format, title }) => (
              <option key={format} value={format}>
                {title}
              </option>
            ))}
          </optgroup>
        ))}
      </select>
      {canManage.value && (
        <Button
          icon="trash"
          tip={`Delete ${snapshot.name}; labels stay`}
          small
          onClick={() => void versions.removeSnapshot(snapshot)}
        />
      )}
    </div>
  );
}

function Compared({ snapshot }: { snapshot: Snapshot }) {
  const others = versions.snapshots.value.filter(({ id }) => id !== snapshot.id);
  const { with: other = '', found } = versions.difference.value ?? {};
  return (
    <section class="stack" aria-label="Difference">
      <h3>Changes since {snapshot.name}</h3>
      <Choice
        label="Compare with"
        value={other}
        choices={[['', 'current labels'], ...others.map(({ id, name }) => [id, name] as const)]}
        onChange={(id) => void versions.compare(snapshot, id)}
      />
      {!found && <p class="soft">Comparing…</p>}
      {found?.length === 0 && <p class="soft">No changes: the labels are the same.</p>}
      {found?.map((each) => (
        <Found key={each.sequence} found={each} />
      ))}
    </section>
  );
}

const CHANGES = [
  ['Frame'],
  ['Added', 'Points that got a label'],
  ['Removed', 'Points that lost their label'],
  ['Changed', 'Points that got another label'],
  ['Objects'],
] as const;

function Found({ found: { sequence, labels, frames } }: { found: Difference }) {
  const objects = (sign: string, { length }: readonly number[]) =>
    length ? `${sign}${length}` : '';
  return (
    <>
      <strong>{rowOf(sequence)?.name ?? sequence}</strong>
      {labels.length > 0 && (
        <Table
          head={[['Label'], ['Change']]}
          rows={labels.map(({ name: called, kind }) => [called, versions.KIND_WORDS[kind] ?? kind])}
        />
      )}
      {frames.length > 0 && (
        <Table
          head={CHANGES}
          rows={frames.map(
            ({ frame, came, went, changed, objects_came: more, objects_went: fewer }) => [
              <Button
                label={String(frame)}
                tip={`Go to frame ${frame}`}
                kind="outlined"
                small
                onClick={() => goTo(sequence, frame)}
              />,
              ...[came, went, changed].map(shortCount),
              `${objects('+', more)} ${objects('−', fewer)}`,
            ],
          )}
        />
      )}
    </>
  );
}
