/** Attributes of the chosen box: built-in ones and the taxonomy's, of the frame or of all of them. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { api } from '../net/rest';
import type { BoxAttribute, Taxonomy } from '../protocol/values';
import type { Attributes, AttributeValue, ObjectBox } from '../store/boxes';
import { canEdit, state } from '../store/state';
import { Check } from '../panels/parts/controls';
import { ChoiceRow, Row } from '../panels/parts/fields';
import { changeBox } from './changes';

const PARKED: BoxAttribute = { name: 'parked', kind: 'yes/no', choices: [], scope: 'track' };
/** As KITTI numbers it. */
const OCCLUDED = ['Fully visible', 'Partly occluded', 'Largely occluded', 'Unknown'];

const NOT_SET = ['', 'not set'] as const;

const defined = signal<readonly BoxAttribute[]>([]);

async function load(): Promise<void> {
  defined.value = (await api<Taxonomy>('GET', 'taxonomy')).attributes;
}

/** The change of a box by an attribute's value; null removes it. */
function set(box: ObjectBox, scope: 'track' | 'frame', name: string, value: AttributeValue | null): void {
  if (scope === 'track') {
    void changeBox(box.id, { attributes: { [name]: value } });
    return;
  }
  const { frame } = state.shown.peek();
  if (!(frame in box.poses)) return;
  void changeBox(box.id, { poses: { [frame]: { attributes: { [name]: value } } } });
} // prettier-ignore

export function BoxAttributes({ box }: { box: ObjectBox }) {
  useEffect(() => void load().catch(() => undefined), []);
  const pose = box.poses[state.shown.value.frame];
  const values: Attributes = { ...box.attributes, ...pose?.attributes };
  const disabled = !canEdit.value;
  return (
    <fieldset class="box-attributes" disabled={disabled}>
      <Check label="Front known" tip="The arrow points to the front of the object, in all frames" checked={box.heading_known} onChange={(heading_known) => void changeBox(box.id, { heading_known })} />
      <ChoiceRow
        label="Occluded"
        value={String(values['occluded'] ?? '')}
        choices={[NOT_SET, ...OCCLUDED.map((text, i) => [String(i), text] as const)]}
        onChange={(value) => setNumber(box, 'occluded', value)}
      />
      <Row label="Truncated" tip="Fraction of the object outside the view of the sensor, 0 to 1">
        <input class="field number" type="number" min={0} max={1} step={0.05} placeholder="0 – 1" value={String(values['truncated'] ?? '')} onChange={(event) => setNumber(box, 'truncated', event.currentTarget.value)} />
      </Row>
      {[PARKED, ...defined.value.filter(({ name }) => name !== 'parked')].map((kind) => (
        <Attribute key={kind.name} kind={kind} value={values[kind.name]} change={(value) => set(box, kind.scope, kind.name, value)} />
      ))}
    </fieldset>
  ); // prettier-ignore
}

function setNumber(box: ObjectBox, name: string, typed: string): void {
  const value = Number(typed);
  set(box, 'frame', name, typed === '' || !Number.isFinite(value) ? null : value);
}

interface AttributeProps {
  kind: BoxAttribute;
  value: AttributeValue | undefined;
  change: (value: AttributeValue | null) => void;
}

function Attribute({ kind: { name, kind, choices, scope }, value, change }: AttributeProps) {
  const tip = scope === 'track' ? 'Applies to all frames' : 'Applies to this frame';
  const label = `${name.charAt(0).toUpperCase()}${name.slice(1)}`;
  if (kind === 'yes/no') {
    return <Check label={label} tip={tip} checked={value === true} onChange={change} />;
  }
  const typed = (text: string): void => {
    change(text === '' ? null : kind === 'number' ? Number(text) : text);
  };
  const text = String(value ?? '');
  if (kind === 'choice') {
    const offered = [NOT_SET, ...choices.map((choice) => [choice, choice] as const)];
    return <ChoiceRow label={label} tip={tip} value={text} choices={offered} onChange={typed} />;
  }
  const input = {
    class: 'field',
    value: text,
    onChange: (event: preact.TargetedEvent<HTMLInputElement>) => typed(event.currentTarget.value),
  };
  return (
    <Row label={label} tip={tip}>
      {kind === 'number' ? <input {...input} type="number" /> : <input {...input} type="text" />}
    </Row>
  );
}
