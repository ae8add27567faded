/** Snapshots of a project's labels: named, compared by label and frame, exported. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { day, plural, shortCount } from '../common/format';
import { exportFormats, groupFormats } from '../engine/export-formats';
import { Button } from '../panels/parts/controls';
import { actions } from '../store/actions';
import { canManage, state } from '../store/state';
import { goTo, project } from './store';
import {
  compare,
  compared,
  createSnapshot,
  type Difference,
  difference,
  type FrameDifference,
  KIND_WORDS,
  loadSnapshots,
  removeSnapshot,
  type Snapshot,
  snapshots,
} from './snapshots';

const name = signal('');

export function Versions() {
  const of = project.value?.id;
  useEffect(() => void loadSnapshots(), [of]);
  useEffect(() => void actions.loadExportFormats(), []);
  return (
    <>
      {canManage.value && <Name />}
      {snapshots.value.length === 0 && <p class="soft empty">No snapshots yet.</p>}
      <ul class="findings">
        {snapshots.value.map((each) => (
          <li key={each.id} data-current={each.id === compared.value?.id || undefined}>
            <Entry snapshot={each} />
          </li>
        ))}
      </ul>
      {compared.value && <Compared snapshot={compared.value} />}
    </>
  );
}

function Name() {
  const submit = (event: Event): void => {
    event.preventDefault();
    const given = name.peek().trim();
    if (!given) return;
    void createSnapshot(given).then((made) => made && (name.value = ''));
  };
  return (
    <form class="snapshot-form" onSubmit={submit}>
      <input
        class="field"
        aria-label="Name of the snapshot"
        placeholder="Name these labels"
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

function Entry({ snapshot }: { snapshot: Snapshot }) {
  const here = snapshot.id === compared.value?.id;
  return (
    <>
      <button
        type="button"
        class="menu-item"
        aria-current={here ? 'true' : undefined}
        onClick={() => void compare(snapshot)}
      >
        <span class="what">
          {snapshot.name}
          <span class="soft">
            {day(snapshot.created)} · {snapshot.author} ·{' '}
            {plural(Object.keys(snapshot.recordings).length, 'recording')}
          </span>
        </span>
      </button>
      {here && <Actions snapshot={snapshot} />}
    </>
  );
}

function Actions({ snapshot }: { snapshot: Snapshot }) {
  const held = (state.sequence.value?.id ?? '') in snapshot.recordings;
  return (
    <div class="finding-actions snapshot-actions">
      <select
        aria-label="Export this recording from the snapshot"
        value=""
        disabled={!held}
        onChange={({ currentTarget }) => {
          void actions.exportSequence(currentTarget.value, '', '', snapshot.id);
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
          onClick={() => void removeSnapshot(snapshot)}
        />
      )}
    </div>
  );
}

function Compared({ snapshot }: { snapshot: Snapshot }) {
  const others = snapshots.value.filter(({ id }) => id !== snapshot.id);
  return (
    <section class="own-tasks" aria-label="Difference">
      <h3>Changes since {snapshot.name}</h3>
      <select
        aria-label="Compare with"
        value={difference.value?.with ?? ''}
        onChange={(event) => void compare(snapshot, event.currentTarget.value)}
      >
        <option value="">current labels</option>
        {others.map((each) => (
          <option key={each.id} value={each.id}>
            {each.name}
          </option>
        ))}
      </select>
      {difference.value === null && <p class="soft">Comparing…</p>}
      {difference.value?.found.length === 0 && (
        <p class="soft">No changes: the labels are the same.</p>
      )}
      {difference.value?.found.map((each) => (
        <Table key={each.sequence} found={each} />
      ))}
    </section>
  );
}

function Table({ found: { sequence, labels, frames } }: { found: Difference }) {
  const title = state.sequences.value?.find(({ id }) => id === sequence)?.name ?? sequence;
  return (
    <>
      <strong>{title}</strong>
      {labels.length > 0 && (
        <table>
          <thead>
            <tr>
              <th>Label</th>
              <th>Change</th>
            </tr>
          </thead>
          <tbody>
            {labels.map(({ label, name: called, kind }) => (
              <tr key={label}>
                <td>{called}</td>
                <td>{KIND_WORDS[kind] ?? kind}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {frames.length > 0 && (
        <table>
          <thead>
            <tr>
              <th>Frame</th>
              <th data-tip="Points that got a label">Added</th>
              <th data-tip="Points that lost their label">Removed</th>
              <th data-tip="Points that got another label">Changed</th>
              <th>Objects</th>
            </tr>
          </thead>
          <tbody>
            {frames.map((each) => (
              <FrameRow key={each.frame} sequence={sequence} row={each} />
            ))}
          </tbody>
        </table>
      )}
    </>
  );
}

function FrameRow({ sequence, row }: { sequence: string; row: FrameDifference }) {
  const { frame, came, went, changed, objects_came: more, objects_went: fewer } = row;
  const objects = [more.length > 0 && `+${more.length}`, fewer.length > 0 && `−${fewer.length}`];
  return (
    <tr>
      <td>
        <button
          type="button"
          class="button small outlined"
          aria-label={`Go to frame ${frame}`}
          onClick={() => goTo(sequence, frame)}
        >
          {frame}
        </button>
      </td>
      {[came, went, changed].map((count, k) => (
        <td key={k} class="number">
          {shortCount(count)}
        </td>
      ))}
      <td class="number">{objects.filter(Boolean).join(' ')}</td>
    </tr>
  );
}
