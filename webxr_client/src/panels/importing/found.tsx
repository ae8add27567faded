/** Findings in files that are about to be imported. */
import type { FileFrame, ImportedLabels, ImportPreview } from '../../protocol/values';
import type { ImportDraft } from '../../store/state';
import { plural } from '../../common/format';

/** Most files for which the list is open at first. */
const OPEN_FILES = 8;
const LISTED_FILES = 500;
/** The server's name of the option to match files by their order. */
const BY_ORDER = ' (--by-order)';
/** Options of the command line in messages of the server that have a field on the page. */
const OPTIONS = / \(--(by-order|topic)[^)]*\)/g;

/** Return a message of the server without options of the command line. */
export function onPage(words: string): string {
  return words.replace(OPTIONS, '');
}

/** Return whether matching by order is chosen, or suggested by a message of the server. */
export function orderCounts({ options, error, found, labels }: ImportDraft): boolean {
  const messages = [error, ...(found?.warnings ?? []), ...(labels?.warnings ?? [])];
  return options.by_order === true || messages.some((words) => words.includes(BY_ORDER));
}

export function Facts({ found }: { found: ImportPreview }) {
  const first = found.points[0];
  const extent = found.units.extent.map((wide) => wide.toFixed(1)).join(' × ');
  const frames = found.frames?.toLocaleString('en') ?? 'unknown';
  const rows: readonly Fact[] = [
    ['Format', found.title],
    ['Frames', found.frames === 1 ? '1' : `${frames}, ${found.order}`],
    ['Rate', found.frames === 1 ? '' : `${found.fps} per second, ${found.fps_from}`],
    ['Points', `${first?.points.toLocaleString('en') ?? '0'} in the first frame`],
    ['Columns', columnsOf(found, false)],
    ['Other fields', columnsOf(found, true)],
    ['Size', `${extent} ${found.units.scale === 1 ? 'm' : found.units.name}`],
    ['Sensors', found.sensors.map(sensor).join(', ')],
    ['Cameras', found.cameras.map(camera).join(', ')],
    ['Labels', found.labels ? 'included with the points' : ''],
  ];
  return (
    <>
      <FactList rows={rows} />
      {new Set(found.files.map(({ file }) => file)).size > 1 && <Files files={found.files} />}
    </>
  );
}

/** Warnings of the server, each folded to one line; of many only the first ones. */
export function Warnings({ lines }: { lines: readonly string[] }) {
  if (lines.length === 0) return null;
  return (
    <details class="note import-note warn small" open={lines.length === 1}>
      <summary>
        <b>{plural(lines.length, 'warning')}</b>
        {lines.map((line) => (
          <span key={line}>{onPage(line)}</span>
        ))}
      </summary>
    </details>
  );
}

/** Table of files and their frames. */
function Files({ files }: { files: readonly FileFrame[] }) {
  return (
    <details class="import-more" open={files.length <= OPEN_FILES}>
      <summary class="soft small">Files and their frames</summary>
      <div
        class="import-files small"
        role="region"
        aria-label="Files and their frames"
        tabIndex={0}
      >
        <table>
          <thead>
            <tr>
              <th scope="col">File</th>
              <th scope="col">Frame</th>
            </tr>
          </thead>
          <tbody>
            {files.slice(0, LISTED_FILES).map(({ file, frame }) => (
              <tr key={`${file} ${frame}`}>
                <td>{file}</td>
                <td class="number">
                  <span aria-hidden="true">→</span> {frame}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
        {files.length > LISTED_FILES && (
          <p class="soft">and {plural(files.length - LISTED_FILES, 'more file')}</p>
        )}
      </div>
    </details>
  );
}

type Fact = readonly [name: string, value: string];

/** List of facts by name, without facts that have no value. */
function FactList({ rows }: { rows: readonly Fact[] }) {
  return (
    <dl class="import-facts stack small">
      {rows
        .filter(([, value]) => value)
        .map(([name, value]) => (
          <div key={name}>
            <dt class="soft">{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
    </dl>
  );
}

/** Columns that have a meaning or are ignored, or the `kept` ones, which are stored as they are. */
function columnsOf({ columns }: ImportPreview, kept: boolean): string {
  const listed = columns.filter(({ meaning }) => (meaning === 'kept') === kept);
  return listed.map(described).join(', ');
}

function described({ name, meaning }: ImportPreview['columns'][number]): string {
  if (meaning === name.toLowerCase() || meaning === 'xyz' || meaning === 'kept') return name;
  return `${name} (${meaning || 'ignored'})`;
}

function sensor({ name, joined, left_out: leftOut }: ImportPreview['sensors'][number]): string {
  return `${name} (${plural(joined, 'frame')}${leftOut > 0 ? `, ${leftOut} left out` : ''})`;
}

function camera({ name, color, intrinsics }: ImportPreview['cameras'][number]): string {
  if (typeof color !== 'string') return String(name);
  return `${String(name)} (colour: ${color}; intrinsics: ${String(intrinsics)})`;
}

export function Labels({ found }: { found: ImportedLabels }) {
  const doubt = found.doubtful > 0 ? `, ${found.doubtful.toLocaleString('en')} in doubt` : '';
  const rows: readonly Fact[] = [
    ['Points', `${found.labelled.toLocaleString('en')} with a label${doubt}`],
    ['Frames', `${found.matched} with labels, ${found.unmatched_frames.length} without`],
    ['Labels', `${Object.keys(found.labels).length}, ${found.new_labels.length} of them new`],
    ['Classes without a name', found.unknown_classes.slice(0, 12).join(', ')],
    ['Files without a frame', found.unmatched_files.slice(0, 6).join(', ')],
    [
      'Locked labels',
      found.locked.length > 0 ? `${found.locked.join(', ')} keep their points` : '',
    ],
  ];
  return (
    <>
      <FactList rows={rows} />
      <Files files={found.files} />
      <Warnings lines={found.warnings} />
    </>
  );
}
