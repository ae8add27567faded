/** The studies of a workspace, for its managers: files, participants, a live view, and results. */
import { signal } from '@preact/signals';
import { render } from 'preact';
import { useEffect, useState } from 'preact/hooks';
import { percent, plural } from '../common/format';
import type { Engine } from '../engine/engine';
import { attempt } from '../engine/recordings/recordings';
import { saveBlob } from '../net/files';
import { api, type ApiError, apiUrl } from '../net/rest';
import { Button, SureButton } from '../panels/parts/controls';
import { Field, Table } from '../panels/parts/fields';
import { useModal } from '../panels/parts/modal';
import type { Participant, StudyInfo } from '../protocol/values';
import { actions } from '../store/actions';
import { limits } from '../store/limits';
import { replay } from './replay-bar';

/** From one look at the participants to the next, milliseconds. */
const LIVE_MS = 2000;
const TEMPLATES = { 'desk-or-headset': 'Desk or headset', 'brush-or-object-tool': 'Brush or object tool' }; // prettier-ignore
const RESULTS = { '/report': 'Report with plots', '/results': 'Results as CSV', '/results?format=parquet': 'Results as Parquet' }; // prettier-ignore

const studies = signal<readonly StudyInfo[]>([]);
/** Id of the study that is shown; null: the list. */
const chosen = signal<string | null>(null);
const participants = signal<readonly Participant[]>([]);
/** Participants that were added here, with the links that the server shows once. */
const added = signal<readonly Participant[]>([]);
const dialogPlace = document.createElement('div');
let engine: Engine;

/** Show the recording as a participant labels it, without tools that would change it. */
function watch(participant: number, sequence: string): void {
  const leave = (): void => {
    limits.value = null;
    actions.recordings.closeSequence();
    openStudies(engine);
  };
  const Bar = () => (
    <div class="line" role="group" aria-label="Live view">
      <strong class="title">Participant {participant}</strong>
      <Button label="Back to the study" kind="outlined" onClick={leave} />
    </div>
  );
  limits.value = { tools: null, hints: true, Bar };
  actions.tools.setTool('navigate');
  actions.recordings.openSequence(sequence);
}

/** Open the studies. */
export function openStudies(of: Engine): void {
  engine = of;
  document.body.append(dialogPlace);
  render(<Studies />, dialogPlace);
}

function close(): void {
  render(null, dialogPlace);
}

function place(rest = ''): string {
  return `studies/${encodeURIComponent(chosen.peek() ?? '')}${rest}`;
}

async function load(): Promise<void> {
  studies.value = await api<StudyInfo[]>('GET', 'studies');
  if (!studies.peek().some(({ id }) => id === chosen.peek())) return;
  participants.value = await api<Participant[]>('GET', place('/participants'));
}

/** Send a change, and load the shown study again. */
async function act(failure: string, work: () => Promise<unknown>): Promise<void> {
  await attempt(failure, work);
  await attempt('The studies did not load', load);
}

function choose(study: string | null): void {
  chosen.value = study;
  participants.value = added.value = [];
}

function Studies() {
  const dialog = useModal();
  useEffect(() => {
    void attempt('The studies did not load', load);
    // A lost connection needs no message each time.
    const timer = setInterval(() => void load().catch(() => undefined), LIVE_MS);
    return () => clearInterval(timer);
  }, [chosen.value]);
  const study = studies.value.find(({ id }) => id === chosen.value);
  return (
    <dialog ref={dialog} class="settings wide" aria-label="Studies" onClose={close}>
      <header class="line">
        {study && <Button icon="back" tip="All studies" onClick={() => choose(null)} />}
        <h2 class="grow">{study?.study.title ?? 'Studies'}</h2>
        <Button icon="close" tip="Close the studies" onClick={close} />
      </header>
      <div class="settings-body stack">{study ? <Study key={study.id} of={study} /> : <List />}</div>
    </dialog>
  ); // prettier-ignore
}

function List() {
  const [creating, setCreating] = useState('');
  const create = async (template: string): Promise<void> => {
    setCreating(template);
    await act('The study was not created', async () =>
      choose((await api<StudyInfo>('POST', 'studies', { template })).id),
    );
    setCreating('');
  };
  return (
    <>
      <p class="soft">
        A study compares ways of labelling. Participants open a link, label the same tasks in each
        condition, and answer questionnaires.
      </p>
      <ul class="settings-rows stack">
        {studies.value.map((each) => (
          <li key={each.id} class="line">
            <strong class="name">{each.study.title}</strong>
            <span class="soft number">{plural(each.participants, 'participant')}, {each.done} done</span>
            <Button label="Open" kind="outlined" small onClick={() => choose(each.id)} />
          </li>
        ))}
      </ul>
      <div class="line">
        {Object.entries(TEMPLATES).map(([template, title]) => (
          <Button key={template} icon="plus" label={creating === template ? 'Generating recordings…' : `New: ${title}`}
            kind="outlined" disabled={creating !== ''} onClick={() => void create(template)} />
        ))}
      </div>
    </>
  ); // prettier-ignore
}

function Study({ of }: { of: StudyInfo }) {
  return (
    <>
      <Participants />
      <h3>Results</h3>
      <div class="line wrap">
        {Object.entries(RESULTS).map(([rest, words]) => (
          <a key={rest} class="button outlined" href={apiUrl(place(rest))} target="_blank" rel="noreferrer">
            {words}
          </a>
        ))}
      </div>
      <File of={of} />
    </>
  ); // prettier-ignore
}

const HEAD = [['No.'], ['Conditions'], ['State'], ['Step'], ['IoU'], ['']] as const;

function Participants() {
  const all = participants.value;
  const submit = (event: SubmitEvent): void => {
    event.preventDefault();
    const count = Number(new FormData(event.currentTarget as HTMLFormElement).get('count'));
    void act('No participant was added', async () => {
      const found = await api<Participant[]>('POST', place('/participants'), { count });
      added.value = [...added.peek(), ...found];
    });
  };
  return (
    <>
      {all.length > 0 && <Table head={HEAD} rows={all.map(rowOf)} />}
      <form class="line" onSubmit={submit}>
        <Field label="" type="number" aria-label="Number of new participants" name="count"
          min={1} max={100} required defaultValue={2} />
        <Button submit label="Add participants" kind="primary" />
      </form>
      {added.value.length > 0 && <Links of={added.value} />}
    </>
  ); // prettier-ignore
}

function Links({ of }: { of: readonly Participant[] }) {
  const lines = of.map(({ number, link }) => `${number},${link}\n`);
  const save = (): void => saveBlob(`${chosen.peek()}-links.csv`, new Blob(lines));
  return (
    <div class="note stack">
      <div class="line spread">
        Save these links now: they are shown only once.
        <Button icon="export" label="Save the links" kind="outlined" small onClick={save} />
      </div>
      {of.map(({ number, link }) => <code key={number}>{number}: {link}</code>)}
    </div>
  ); // prettier-ignore
}

function rowOf(one: Participant) {
  const { number, conditions, state, step, count, kind, task, iou, sequence, records } = one;
  const path = place(`/participants/${number}`);
  const paused = state === 'paused';
  const tip = `${paused ? 'Continue' : 'Pause'} the session of participant ${number}`;
  const pause = (): void =>
    void act('The session was not paused', () => api('PATCH', path, { paused: !paused }));
  const remove = (): void => void act('The participant was not deleted', () => api('DELETE', path));
  const leaveTo = (run: () => unknown): void => {
    close();
    run();
  };
  return [
    number,
    conditions.join(', '),
    <span class={paused ? 'pill warn' : 'pill'}>{state}</span>,
    `${step + 1} of ${count} · ${task ? `${kind} ${task}` : kind}`,
    iou === null ? '' : percent(iou),
    <div class="line">
      {state !== 'waiting' && state !== 'done' && <Button icon={paused ? 'play' : 'pause'} tip={tip} small onClick={pause} />}
      {sequence && <Button icon="eye" tip={`Look at the recording of participant ${number}`} small
        onClick={() => leaveTo(() => watch(number, sequence))} />}
      {records > 0 && <Button icon="history" tip={`Replay participant ${number}`} small
        onClick={() => leaveTo(() => replay(engine, number, path))} />}
      <SureButton label="Delete" tip={`Delete participant ${number} with all data`} onClick={remove} />
    </div>,
  ]; // prettier-ignore
}

function File({ of }: { of: StudyInfo }) {
  const [text, setText] = useState(of.text);
  const [refusal, setRefusal] = useState('');
  const fixed = of.participants > 0;
  const save = async (): Promise<void> => {
    setRefusal('');
    await api('PUT', place(), { text }).catch((error: unknown) =>
      setRefusal((error as ApiError).message),
    );
    await load();
  };
  return (
    <>
      <h3>File</h3>
      {fixed && <p class="soft">A study with participants cannot be changed.</p>}
      <textarea class="field" aria-label="File of the study" spellcheck={false} style={{ height: '40vh', fontFamily: 'var(--font-code)' }}
        value={text} readOnly={fixed} onInput={({ currentTarget }) => setText(currentTarget.value)} />
      {refusal && <p class="note bad" role="alert">{refusal}</p>}
      <footer class="line spread">
        <SureButton label="Delete the study and all data" tip="Delete the study" onClick={() =>
          void act('The study was not deleted', () => api('DELETE', place()))} />
        <Button label="Save" kind="primary" disabled={fixed || text === of.text} onClick={() => void save()} />
      </footer>
    </>
  ); // prettier-ignore
}
