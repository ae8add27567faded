/** Between a drop and an import: what was found, and what a person says it is. */
import type { ComponentChildren } from 'preact';
import { FIRST, projects } from '../../engine/projects';
import { actions } from '../../store/actions';
import { state, type ImportDraft, type ImportOptions, type ImportPreview } from '../../store/state';
import { Button, Check } from '../parts/controls';
import { useModal } from '../parts/modal';
import { plural } from '../../common/format';
import { Icon } from '../../common/icons';
import { Facts, Labels, onPage, orderCounts } from './found';

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
    void actions.takeImport();
  };
  const ready = !draft.busy && (draft.sequence ? draft.labels !== null : draft.found !== null);
  return (
    <dialog
      ref={dialog}
      class="import"
      aria-label="Import"
      onCancel={(event) => {
        event.preventDefault();
        void actions.leaveImport();
      }}
    >
      <form onSubmit={submit}>
        <header>
          <h2>{draft.sequence ? 'Import labels' : 'Import a recording'}</h2>
          {draft.busy && <div class="spinner small" role="status" aria-label="Reading the files" />}
        </header>
        <Target draft={draft} />
        {draft.error && (
          <p class="import-note bad" role="alert">
            <Icon name="warning" /> <span>{onPage(draft.error)}</span>
          </p>
        )}
        {orderCounts(draft) && (
          <Check
            label="Match files to frames by order, not by name"
            checked={draft.options.by_order ?? false}
            onChange={(checked) => correct({ by_order: checked || null })}
          />
        )}
        {draft.sequence ? (
          draft.labels && <Labels found={draft.labels} />
        ) : (
          <Recording draft={draft} />
        )}
        <footer>
          <Button label="Cancel" onClick={() => void actions.leaveImport()} />
          <button type="submit" class="button primary" disabled={!ready} data-autofocus>
            {draft.sequence ? 'Import labels' : 'Import'}
          </button>
        </footer>
      </form>
    </dialog>
  );
}

/** Files dropped on an open recording can be its labels, or another recording. */
function Target({ draft }: { draft: ImportDraft }) {
  const open = state.sequence.value;
  if (!open || !draft.files) return null;
  const choose = (sequence: string | null): void => void actions.retargetImport(sequence);
  return (
    <div class="group" role="group" aria-label="Content of the files">
      <Button
        label="A new recording"
        pressed={draft.sequence === null}
        onClick={() => choose(null)}
      />
      <Button
        label={`Labels of ${open.name}`}
        pressed={draft.sequence !== null}
        onClick={() => choose(open.id)}
      />
    </div>
  );
}

function correct(patch: Partial<Record<keyof ImportOptions, unknown>>): void {
  void actions.correctImport(patch);
}

function Recording({ draft }: { draft: ImportDraft }) {
  const { found, options } = draft;
  return (
    <>
      {found && <Facts found={found} />}
      <div class="import-fields">
        {projects.value.length > 1 && (
          <Row label="Project">
            <Choice
              value={options.project ?? FIRST}
              choices={projects.value.map(({ id, name }) => [id, name] as const)}
              onChange={(id) => correct({ project: id === FIRST ? null : id })}
            />
          </Row>
        )}
        <Row label="Name">
          <input
            class="field"
            value={options.name ?? found?.name ?? ''}
            maxLength={200}
            onChange={(event) => correct({ name: event.currentTarget.value.trim() || null })}
          />
        </Row>
        <Row label="Frames per second">
          <input
            class="field"
            type="number"
            min="0.001"
            max="1000"
            step="any"
            value={options.fps ?? found?.fps ?? ''}
            onChange={(event) => correct({ fps: Number(event.currentTarget.value) || null })}
          />
        </Row>
        <Row label="Unit">
          <Choice
            value={String(options.scale ?? 1)}
            choices={UNITS}
            onChange={(value) => correct({ scale: value === '1' ? null : Number(value) })}
          />
        </Row>
        <UpAxis found={found} options={options} />
        {found && <Topics found={found} options={options} />}
        <Poses found={found} options={options} />
      </div>
      <OtherWays draft={draft} />
    </>
  );
}

interface CorrectedProps {
  found: ImportPreview | null;
  options: ImportOptions;
}

function UpAxis({ found, options }: CorrectedProps) {
  return (
    <Row label="Up">
      <Choice
        value={options.up ?? ''}
        choices={[
          ['', found ? `automatic: ${signed(found.up)}` : 'automatic'],
          ...AXES.map((axis) => [axis, signed(axis)] as const),
        ]}
        onChange={(value) => correct({ up: value || null })}
      />
    </Row>
  );
}

function Poses({ found, options }: CorrectedProps) {
  const poses = found?.poses;
  if (!poses && !options.poses) return null;
  return (
    <Check
      label={`Use the poses${poses ? ` from ${poses.source}` : ''}`}
      checked={options.poses !== 'none'}
      onChange={(checked) => correct({ poses: checked ? null : 'none' })}
    />
  );
}

/** Corrections of what the files say of themselves. */
function OtherWays({ draft: { found, options, error } }: { draft: ImportDraft }) {
  return (
    <details class="import-more" open={error !== ''}>
      <summary>Reading options</summary>
      <div class="import-fields">
        <Row label="Format">
          <Choice
            value={options.format ?? ''}
            choices={[['', 'automatic'], ...FORMATS]}
            onChange={(value) => correct({ format: value || null })}
          />
        </Row>
        <Row label="Columns">
          <input
            class="field"
            value={options.columns ?? ''}
            placeholder={
              found?.columns.map(({ meaning }) => meaning || '-').join(',') ?? 'x,y,z,intensity'
            }
            spellcheck={false}
            onChange={(event) => correct({ columns: event.currentTarget.value.trim() || null })}
          />
        </Row>
        <Row label="Delimiter">
          <Choice
            value={options.delimiter ?? ''}
            choices={[['', 'automatic'], ...DELIMITERS.map((each) => [each, each] as const)]}
            onChange={(value) => correct({ delimiter: value || null })}
          />
        </Row>
        <Row label="Read 1,5 as">
          <Choice
            value={options.decimal_comma === undefined ? '' : String(options.decimal_comma)}
            choices={[
              ['', 'automatic'],
              ['true', 'one and a half'],
              ['false', 'two values'],
            ]}
            onChange={(value) => correct({ decimal_comma: value ? value === 'true' : null })}
          />
        </Row>
        <Check
          label="Leave out invalid points (NaN, infinite)"
          checked={options.drop_invalid ?? false}
          onChange={(checked) => correct({ drop_invalid: checked || null })}
        />
      </div>
    </details>
  );
}

function signed(axis: string): string {
  return axis.startsWith('-') ? `−${axis.slice(1)}` : `+${axis}`;
}

function Topics({ found, options }: { found: ImportPreview; options: ImportOptions }) {
  if (found.topics.length < 2) return null;
  return (
    <Row label="Topic">
      <Choice
        value={options.topic ?? found.topics.find((topic) => topic.read)?.name ?? ''}
        choices={found.topics
          .filter((topic) => topic.clouds)
          .map((topic) => [topic.name, `${topic.name} · ${plural(topic.messages, 'message')}`])}
        onChange={(value) => correct({ topic: value })}
      />
    </Row>
  );
}

function Row({ label, children }: { label: string; children: ComponentChildren }) {
  return (
    <label class="row">
      <span>{label}</span>
      {children}
    </label>
  );
}

interface ChoiceProps {
  value: string;
  choices: readonly (readonly [string, string])[];
  onChange: (value: string) => void;
}

function Choice({ value, choices, onChange }: ChoiceProps) {
  return (
    <select class="field" value={value} onChange={(event) => onChange(event.currentTarget.value)}>
      {choices.map(([id, name]) => (
        <option key={id} value={id}>
          {name}
        </option>
      ))}
    </select>
  );
}
