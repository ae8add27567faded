/** Dialog between a drop and an import: findings in the files, and corrections of them. */
import {
  correctImport,
  leaveImport,
  retargetImport,
  takeImport,
} from '../../engine/recordings/importing';
import { areReady, partsOfFiles } from '../../engine/recordings/import-parts';
import { FIRST, projects } from '../../engine/recordings/projects';
import type { ImportPreview } from '../../protocol/values';
import { state, type ImportDraft, type ImportOptions } from '../../store/state';
import { Button, Check } from '../parts/controls';
import { ChoiceRow, Row } from '../parts/fields';
import { useModal } from '../parts/modal';
import { plural } from '../../common/format';
import { Icon } from '../../common/icons';
import { Facts, Labels, onPage, orderCounts, Warnings } from './found';
import { MaskPreview } from './mask-preview';
import { PartsTable } from './parts-table';

const FORMATS = [
  ['ply', 'PLY'], ['pcd', 'PCD'], ['las', 'LAS, LAZ, COPC'], ['e57', 'E57'], ['text', 'Text'],
  ['npy', 'NPY'], ['npz', 'NPZ'], ['kitti', 'KITTI .bin (4 floats)'],
  ['nuscenes', 'nuScenes .bin (5 floats)'], ['xyzrgb', 'x y z r g b floats'],
  ['rgbd', 'Depth images'], ['rosbag1', 'ROS 1 bag'], ['rosbag2', 'ROS 2 bag'], ['mcap', 'MCAP'],
] as const; // prettier-ignore
const UNITS = [
  ['1', 'metres'], ['0.01', 'centimetres'], ['0.001', 'millimetres'], ['0.0254', 'inches'],
  ['0.3048', 'feet'],
] as const; // prettier-ignore
const AXES = ['z', 'y', '-y', '-z', 'x', '-x'] as const;
const DELIMITERS = ['comma', 'semicolon', 'tab', 'space', 'pipe'] as const;

export function ImportDialog() {
  const draft = state.importing.value;
  const dialog = useModal(draft !== null);
  if (!draft) return null;
  const submit = (event: Event): void => {
    event.preventDefault();
    void takeImport();
  };
  const { title, button } = wordsOf(draft);
  return (
    <dialog
      ref={dialog}
      class={draft.parts ? 'import several wide' : 'import'}
      aria-label="Import"
      onCancel={(event) => {
        event.preventDefault();
        void leaveImport();
      }}
    >
      <form onSubmit={submit}>
        <header class="line spread">
          <h2>{title}</h2>
          {draft.busy && <div class="spinner small" role="status" aria-label="Reading the files" />}
        </header>
        <div class="import-body stack">
          <Content draft={draft} />
        </div>
        <footer class="line">
          <Button label="Cancel" onClick={() => void leaveImport()} />
          <Button submit label={button} kind="primary" disabled={!isReady(draft)} />
        </footer>
      </form>
    </dialog>
  );
}

function wordsOf({ sequence, parts }: ImportDraft): { title: string; button: string } {
  if (sequence) return { title: 'Import labels', button: 'Import labels' };
  if (!parts) return { title: 'Import a recording', button: 'Import' };
  const chosen = parts.filter(({ included }) => included).length;
  return { title: 'Import recordings', button: `Import ${plural(chosen, 'recording')}` };
}

function isReady({ parts, busy, sequence, labels, found }: ImportDraft): boolean {
  return parts ? areReady(parts) : !busy && (sequence ? labels : found) !== null;
}

function Content({ draft }: { draft: ImportDraft }) {
  const { parts, sequence, labels, error, options } = draft;
  return (
    <>
      <Target draft={draft} />
      {error && (
        <p class="note bad line start small" role="alert">
          <Icon name="warning" /> <span>{onPage(error)}</span>
        </p>
      )}
      {orderCounts(draft) && (
        <Check
          label="Match files to frames by order, not by name"
          checked={options.by_order ?? false}
          onChange={(checked) => void correctImport({ by_order: checked || null })}
        />
      )}
      {parts && <PartsTable parts={parts} busy={draft.busy} />}
      {sequence
        ? labels && (
            <>
              <MaskPreview draft={draft} />
              <Labels found={labels} />
            </>
          )
        : draft.decided && <Recording draft={draft} />}
    </>
  );
}

/** Files can be a recording, several, or labels of the open one. */
function Target({ draft: { files, sequence, parts, decided } }: { draft: ImportDraft }) {
  const open = state.sequence.value;
  const several = files ? (parts ?? partsOfFiles(files)).length : 0;
  if (!files || (!open && several < 2)) return null;
  const choose = (target: string | null, each = false): void => void retargetImport(target, each);
  return (
    <div class="segmented" role="group" aria-label="Content of the files">
      <Button
        label="One recording"
        pressed={decided && sequence === null && !parts}
        onClick={() => choose(null)}
      />
      {several > 1 && (
        <Button
          label={`${several} recordings`}
          tip="Each file or folder is a recording"
          pressed={parts !== null}
          onClick={() => choose(null, true)}
        />
      )}
      {open && (
        <Button
          label={`Labels of ${open.name}`}
          pressed={sequence !== null}
          onClick={() => choose(open.id)}
        />
      )}
    </div>
  );
}

function Recording({ draft }: { draft: ImportDraft }) {
  const { options, parts } = draft;
  const found = parts ? null : draft.found;
  return (
    <>
      {found && <Warnings lines={found.warnings} />}
      <div class="import-fields stack">
        <ProjectOf options={options} />
        {!parts && <Name found={found} options={options} />}
        <Row label="Frames per second">
          <input
            class="field"
            type="number"
            min="0.001"
            max="1000"
            step="any"
            value={options.fps ?? found?.fps ?? ''}
            onChange={(event) =>
              void correctImport({ fps: Number(event.currentTarget.value) || null })
            }
          />
        </Row>
        <Axes found={found} options={options} />
        <Topics found={found} options={options} />
        <Poses found={found} options={options} />
      </div>
      {found && <Facts found={found} />}
      <OtherWays draft={draft} />
    </>
  );
}

function ProjectOf({ options }: { options: ImportOptions }) {
  if (projects.value.length < 2) return null;
  return (
    <ChoiceRow
      label="Project"
      value={options.project ?? FIRST}
      choices={projects.value.map((each) => [each.id, each.name] as const)}
      onChange={(chosen) => void correctImport({ project: chosen === FIRST ? null : chosen })}
    />
  );
}

function Name({ found, options }: CorrectedProps) {
  return (
    <Row label="Name">
      <input
        class="field"
        value={options.name ?? found?.name ?? ''}
        maxLength={200}
        onChange={(event) => void correctImport({ name: event.currentTarget.value.trim() || null })}
      />
    </Row>
  );
}

interface CorrectedProps {
  found: ImportPreview | null;
  options: ImportOptions;
}

function Axes({ found, options }: CorrectedProps) {
  return (
    <>
      <ChoiceRow
        label="Unit"
        value={String(options.scale ?? 1)}
        choices={UNITS}
        onChange={(value) => void correctImport({ scale: value === '1' ? null : Number(value) })}
      />
      <ChoiceRow
        label="Up"
        value={options.up ?? ''}
        choices={[
          ['', found ? `automatic: ${signed(found.up)}` : 'automatic'],
          ...AXES.map((axis) => [axis, signed(axis)] as const),
        ]}
        onChange={(value) => void correctImport({ up: value || null })}
      />
    </>
  );
}

function Poses({ found, options }: CorrectedProps) {
  const poses = found?.poses;
  if (!poses && !options.poses) return null;
  return (
    <Check
      label={`Use the poses${poses ? ` from ${poses.source}` : ''}`}
      checked={options.poses !== 'none'}
      onChange={(checked) => void correctImport({ poses: checked ? null : 'none' })}
    />
  );
}

/** Corrections of the files' own data. */
function OtherWays({ draft: { found, options, error } }: { draft: ImportDraft }) {
  return (
    <details class="import-more" open={error !== ''}>
      <summary class="soft small">Reading options</summary>
      <div class="import-fields stack">
        <ChoiceRow
          label="Format"
          value={options.format ?? ''}
          choices={[['', 'automatic'], ...FORMATS]}
          onChange={(value) => void correctImport({ format: value || null })}
        />
        <Row label="Columns">
          <input
            class="field"
            value={options.columns ?? ''}
            placeholder={
              found?.columns.map(({ meaning }) => meaning || '-').join(',') ?? 'x,y,z,intensity'
            }
            spellcheck={false}
            onChange={(event) =>
              void correctImport({ columns: event.currentTarget.value.trim() || null })
            }
          />
        </Row>
        <ChoiceRow
          label="Delimiter"
          value={options.delimiter ?? ''}
          choices={[['', 'automatic'], ...DELIMITERS.map((each) => [each, each] as const)]}
          onChange={(value) => void correctImport({ delimiter: value || null })}
        />
        <ChoiceRow
          label="Read 1,5 as"
          value={options.decimal_comma === undefined ? '' : String(options.decimal_comma)}
          choices={[
            ['', 'automatic'],
            ['true', 'one and a half'],
            ['false', 'two values'],
          ]}
          onChange={(value) =>
            void correctImport({ decimal_comma: value ? value === 'true' : null })
          }
        />
        <Check
          label="Leave out invalid points (NaN, infinite)"
          checked={options.drop_invalid ?? false}
          onChange={(checked) => void correctImport({ drop_invalid: checked || null })}
        />
      </div>
    </details>
  );
}

function signed(axis: string): string {
  return axis.startsWith('-') ? `−${axis.slice(1)}` : `+${axis}`;
}

function Topics({ found, options }: CorrectedProps) {
  const all = options.sensors === 'all';
  const clouds = found?.topics.filter((topic) => topic.clouds) ?? [];
  return (
    <>
      {!all && found && found.topics.length > 1 && (
        <ChoiceRow
          label="Topic"
          value={options.topic ?? found.topics.find((topic) => topic.read)?.name ?? ''}
          choices={clouds.map(({ name, messages }) => [
            name,
            `${name} · ${plural(messages, 'message')}`,
          ])}
          onChange={(value) => void correctImport({ topic: value })}
        />
      )}
      {(all || clouds.length > 1) && (
        <Check
          label="All sensors in one recording"
          checked={all}
          onChange={(checked) => void correctImport({ sensors: checked ? 'all' : null })}
        />
      )}
    </>
  );
}
