/** The controls of a replay, in the tool bar. */
import { signal } from '@preact/signals';
import { clock } from '../common/format';
import type { Engine } from '../engine/engine';
import { attempt } from '../engine/recordings/recordings';
import { api } from '../net/rest';
import { Button, Progress, Slider } from '../panels/parts/controls';
import { Choice } from '../panels/parts/fields';
import type { LogRecord, StudyStep } from '../protocol/values';
import { actions } from '../store/actions';
import { limits } from '../store/limits';
import { notify } from '../store/state';
import { duration, plays, Replay, speed, time } from './replay';

const SPEEDS = ['0.5', '1', '2', '4', '8', '16'].map((each) => [each, `${each}×`] as const);

/** Steps of one participant, with their records. */
let steps: readonly StudyStep[] = [];
let log: readonly LogRecord[] = [];
let running: Replay | null = null;
const step = signal(0);
/** Done share of the pictures that are saved; null: none are. */
const saving = signal<number | null>(null);

/** Open the log of a participant at its first task; `path`: of the participant. */
export function replay(engine: Engine, participant: number, path: string): Promise<void> {
  return attempt('The log did not load', async () => {
    const found = api<StudyStep[]>('GET', `${path}/steps`);
    log = await api<LogRecord[]>('GET', `${path}/log?format=json`);
    steps = (await found).filter(({ number }) => log.some((record) => record.step === number));
    const name = `Participant ${participant}`;
    if (steps.length === 0) {
      notify('info', 'The log is empty', `${name} has not begun a task.`);
      return;
    }
    running?.stop();
    running = new Replay(engine, name);
    limits.value = { tools: null, hints: true, Bar: ReplayBar };
    actions.tools.setTool('navigate');
    await show(steps[0]!.number);
  });
}

async function show(number: number): Promise<void> {
  step.value = number;
  const { sequence } = steps.find((each) => each.number === number)!;
  const records = log.filter((record) => record.step === number);
  await attempt('The step did not load', () => running!.open(sequence!, records));
}

function close(): void {
  running?.stop();
  running = limits.value = null;
}

async function save(): Promise<void> {
  const progress = (share: number): void => void (saving.value = share);
  await attempt('The pictures were not saved', () => running!.save(progress));
  saving.value = null;
}

function ReplayBar() {
  const play = (): void => {
    if (time.value === duration.value) time.value = 0;
    plays.value = !plays.peek();
  };
  return (
    <div class="line" role="group" aria-label="Replay">
      <Choice label="Step" value={String(step.value)}
        choices={steps.map(({ number, condition, task }) => [String(number), `${condition?.name}: ${task?.name}`])}
        onChange={(number) => void show(Number(number))} />
      <Button icon={plays.value ? 'pause' : 'play'} tip={plays.value ? 'Pause the replay' : 'Play the replay'} onClick={play} />
      <Slider label="Time" before="" min={0} max={Math.max(1, duration.value)} value={time.value}
        shown={clock(time.value / 1000)} onInput={(to) => (time.value = to)} />
      <Choice label="Speed" value={String(speed.value)} choices={SPEEDS} onChange={(each) => (speed.value = Number(each))} />
      {saving.value === null
        ? <Button icon="export" tip="Save the replay as pictures" onClick={() => void save()} />
        : <Progress share={saving.value} label="Pictures" />}
      <Button icon="close" tip="Close the replay" onClick={close} />
    </div>
  ); // prettier-ignore
}
