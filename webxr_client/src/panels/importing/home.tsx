/** The start page: all recordings in a table, by project. */
import { signal } from '@preact/signals';
import { useEffect, useMemo, useState } from 'preact/hooks';
import {
  grouped,
  projects,
  refreshProjects,
  tasksOf,
  type Group,
} from '../../engine/recordings/projects';
import {
  chooseOrder,
  descending,
  matching,
  order,
  ORDERS,
  sorted,
  type Order,
} from '../../engine/recordings/list';
import { Icon } from '../../common/icons';
import { keep, kept } from '../../store/kept';
import { canManage, type SequenceSummary } from '../../store/state';
import { inSight, listStyle, useSight, type Sight } from '../parts/scrolled';
import { Filter, filtered } from './filter';
import { ImportButton } from './import-box';
import { NewProject } from './new-project';
import { NextWork, ProjectHead, SettingsButton } from './project-head';
import { RecordingName, RecordingSearch, renamingRecording, Row } from './recordings';

const FOLDED = 'pointbrush.folded-projects';
/** Ids of folded projects. */
const folded = signal<ReadonlySet<string>>(new Set(kept(FOLDED)?.split(' ')));

function fold(id: string): void {
  const others = new Set(folded.peek());
  if (!others.delete(id)) others.add(id);
  folded.value = others;
  keep(FOLDED, [...others].join(' '));
}

export function Recordings({ sequences }: { sequences: readonly SequenceSummary[] }) {
  const [text, setText] = useState('');
  const [named, setNamed] = useState(projects.peek().length > 0);
  useEffect(() => void refreshProjects().then(() => setNamed(true)), [sequences]);
  const [by, down, found, known] = [order.value, descending.value, filtered.value, projects.value];
  const rows = useMemo(() => {
    const met = sequences.filter(({ id }) => found?.has(id) ?? true);
    return sorted(matching(met, text), by, down);
  }, [sequences, found, text, by, down]);
  const groups = useMemo(() => grouped(rows, known), [rows, known]);
  const isSearching = text !== '' || found !== null;
  const only = known.length === 1 && !hasTasks(groups) ? known[0]! : null;
  return (
    <>
      <header class="home-head line wrap">
        <h1>Recordings</h1>
        <RecordingSearch of={sequences} text={text} onInput={setText} />
        <Filter />
        <span class="soft number" role="status">
          {isSearching && `${rows.length} found`}
        </span>
        <span class="spacer" />
        {canManage.value && only && <SettingsButton project={only} />}
        {canManage.value && <NewProject rows={isSearching ? rows : []} />}
        {canManage.value && <ImportButton />}
        <NextWork of={projects.value} />
      </header>
      {named && (
        <Table
          groups={groups.filter((group) => !isSearching || group.rows.length > 0)}
          headed={only === null}
          isSearching={isSearching}
        />
      )}
    </>
  );
}

function hasTasks(groups: readonly Group[]): boolean {
  return groups.some(({ project }) => tasksOf(project.tasks ?? {}) > 0);
}

interface TableProps {
  groups: readonly Group[];
  /** Projects have heads. */
  headed: boolean;
  isSearching: boolean;
}

function Table({ groups, headed, isSearching }: TableProps) {
  const [box, sight] = useSight();
  let offset = 1;
  return (
    <div ref={box} class="home-table">
      <Headings />
      {groups.length === 0 && <p class="home-none soft">No recording matches the search.</p>}
      {groups.map(({ project, rows }) => {
        const shown = !headed || isSearching || !folded.value.has(project.id);
        const begin = offset + (headed ? 1 : 0);
        offset = begin + (shown ? Math.max(1, rows.length) : 0);
        return (
          <section key={project.id} aria-label={project.name}>
            {headed && (
              <ProjectHead
                project={project}
                rows={rows}
                shown={shown}
                onFold={() => fold(project.id)}
              />
            )}
            {shown && <Rows rows={rows} offset={begin} sight={sight} />}
          </section>
        );
      })}
    </div>
  );
}

const HEADINGS: Readonly<Record<Order, string>> = {
  name: 'Name', frames: 'Length', points: 'Points', progress: 'Labelled', changed: 'Changed',
}; // prettier-ignore

function Headings() {
  return (
    <div class="home-headings" role="group" aria-label="Order">
      {ORDERS.map((each) => (
        <button
          key={each}
          type="button"
          class="button small"
          data-order={each}
          aria-pressed={order.value === each}
          data-tip={`Order by ${HEADINGS[each].toLowerCase()}`}
          onClick={() => chooseOrder(each)}
        >
          {HEADINGS[each]}
          {order.value === each && <Icon name={descending.value ? 'chevron' : 'up'} />}
        </button>
      ))}
      <span>Labels in use</span>
    </div>
  );
}

interface RowsProps {
  rows: readonly SequenceSummary[];
  /** Rows above the first. */
  offset: number;
  sight: Sight;
}

/** Recordings of a project; only rows in sight are drawn. */
function Rows({ rows, offset, sight }: RowsProps) {
  const [from, until] = inSight(sight, offset, rows.length);
  if (rows.length === 0) return <p class="home-none soft">No recordings yet.</p>;
  return (
    <ul class="rows" style={listStyle(rows.length, from)}>
      {rows.slice(from, until).map((row, k) => (
        <li
          key={row.id}
          class="recording-line"
          aria-setsize={rows.length}
          aria-posinset={from + k + 1}
        >
          {renamingRecording.value === row.id ? <RecordingName row={row} /> : <Row row={row} />}
        </li>
      ))}
    </ul>
  );
}
