/** Finding people without a click: search in the frame on screen, preview, one edit, tracking, export. */
import { computed, signal } from '@preact/signals';
import { plural } from '../common/format';
import type { IconName } from '../common/icons';
import { api } from '../net/rest';
import type { FoundPeople, FoundPerson, Job } from '../protocol/values';
import { actions } from '../store/actions';
import { canEdit, isActive, notify, state, trackingJob } from '../store/state';
import { watch } from '../store/watch';
import { FOUND, MOST_FOUND } from '../cloud/picture/palette';
import type { CloudFrame } from '../cloud/points/frame';
import { numbersOfRuns } from '../protocol/codec';
import type { Engine } from './engine';
import { exportFormats, lastExport } from './recordings/export-formats';
import {
  attempt,
  exportSequence,
  finished,
  loadExportFormats,
  sequencePath,
  succeeds,
} from './recordings/recordings';

/** Step of finding people; `frame`: the searched frame; `people`: the found ones. */
export interface PeopleStep {
  readonly at: 'searching' | 'found' | 'labelling' | 'labelled' | 'tracking' | 'tracked';
  readonly frame: number;
  readonly people: readonly FoundPerson[];
}

/** The current step; null: none. */
export const peopleStep = signal<PeopleStep | null>(null);

/** Ids of the labels of the found people. */
const labels = computed((): readonly number[] => {
  const names = new Set(peopleStep.value?.people.map(({ name }) => name));
  return state.palette.value.filter(({ name }) => names.has(name)).map(({ id }) => id);
});

function setStep(at: PeopleStep['at']): void {
  const step = peopleStep.peek();
  if (step) peopleStep.value = { ...step, at };
}

/** Search the frame on screen for people; no label changes. */
export async function findPeople(): Promise<void> {
  const info = state.sequence.peek();
  const { frame } = state.shown.peek();
  if (!info || frame < 0 || !canEdit.peek()) return;
  actions.time.pause();
  const search: PeopleStep = { at: 'searching', frame, people: [] };
  peopleStep.value = search;
  const answered = await succeeds('People were not searched', async () => {
    const path = `${sequencePath(info.id)}/people?format=stored`;
    const { people } = await api<FoundPeople>('POST', path, { frames: [frame] });
    if (peopleStep.peek() !== search) return;
    peopleStep.value = people.length > 0 ? { at: 'found', frame, people } : null;
    if (people.length === 0) notify('info', 'No people in this frame', 'Try a frame that shows them larger.'); // prettier-ignore
  });
  if (!answered && peopleStep.peek() === search) peopleStep.value = null;
}

/** Label the people of the preview, as one edit; return false if there is no preview. */
export function acceptPeople(): boolean {
  const step = peopleStep.peek();
  if (step?.at !== 'found') return false;
  void accept(step);
  return true;
}

async function accept({ frame }: PeopleStep): Promise<void> {
  setStep('labelling');
  const path = `${sequencePath(state.sequence.peek()!.id)}/people`;
  const done = await succeeds('The people were not labelled', async () => {
    const id = crypto.randomUUID();
    await finished(id, api<Job>('POST', path, { id, frames: [frame], apply: true }));
  });
  if (peopleStep.peek()?.at === 'labelling') setStep(done ? 'labelled' : 'found');
}

/** Discard the preview or skip the next step; return false if there is no step. */
export function leavePeople(): boolean {
  const active = peopleStep.peek() !== null;
  peopleStep.value = null;
  return active;
}

function track(): void {
  const { frame } = peopleStep.peek()!;
  const last = (state.sequence.peek()?.frames ?? 1) - 1;
  setStep('tracking');
  const stop = frame < last ? last : 0;
  actions.tracking.track({ labels: [...labels.peek()], start: frame, stop, method: 'auto', overwrite: 'tracked' }); // prettier-ignore
}

/** Format of the export: the last one used, or the server's first one. */
const format = computed(() => {
  const known = exportFormats.value;
  return known.find(({ format }) => format === lastExport.value) ?? known[0];
});

function exportNow(): void {
  peopleStep.value = null;
  void attempt('The export did not start', async () => {
    await loadExportFormats();
    if (format.peek()) await exportSequence(format.peek()!.format);
  });
}

export interface StepButton {
  readonly text: string;
  readonly icon: IconName;
  readonly disabled?: boolean;
  readonly run: () => unknown;
}

/** Text and buttons of a step, for the desk and the headset; Enter and the trigger press `main`. */
export interface StepOffer {
  readonly text: string;
  readonly busy: boolean;
  readonly main: StepButton | null;
  readonly leave: string;
}

const TEXTS: Readonly<Record<PeopleStep['at'], (people: string) => string>> = {
  searching: () => 'Looking for people…',
  found: (people) => `${people} found`,
  labelling: (people) => `Labelling ${people}…`,
  labelled: (people) => `${people} labelled`,
  tracking: (people) => `Tracking ${people}…`,
  tracked: (people) => `${people} tracked`,
};

export const peopleOffer = computed((): StepOffer | null => {
  const step = peopleStep.value;
  if (!step) return null;
  const { at, people } = step;
  const count = people.length === 1 ? '1 person' : plural(people.length, 'person').replace('persons', 'people'); // prettier-ignore
  return {
    text: TEXTS[at](count),
    busy: at.endsWith('ing'),
    main: mainOf(step),
    leave: at === 'found' ? 'Discard' : 'Close',
  };
});

function mainOf({ at, frame }: PeopleStep): StepButton | null {
  if (at === 'found') return { text: 'Accept', icon: 'check', run: acceptPeople };
  if (at === 'labelled' && (state.sequence.value?.frames ?? 1) > 1) {
    const { rows } = state.timeline.value;
    const disabled = !labels.value.some((id) => (rows.get(id)?.points[frame] ?? 0) > 0);
    return { text: 'Track', icon: 'track', disabled, run: track };
  }
  if (at !== 'labelled' && at !== 'tracked') return null;
  return { text: 'Export', icon: 'export', run: exportNow };
}

const OVERLAY = 'people';

/** Shows the found people in the colours of their labels, and follows the run that tracks them. */
export class PeoplePreview {
  private shown: CloudFrame | null = null;
  /** Id of the tracking run. */
  private run: string | null = null;

  constructor(private readonly engine: Engine) {
    watch([peopleStep], () => this.show());
    watch([state.jobs], () => this.followRun());
    watch([state.frame], () => {
      const step = peopleStep.peek();
      if (step?.at === 'found' && step.frame !== state.frame.peek()) leavePeople();
    });
    watch([state.sequence], () => {
      if (!state.sequence.peek()) leavePeople();
    });
  }

  private show(): void {
    const { viewer, playback } = this.engine;
    const { at, frame = -1, people = [] } = peopleStep.peek() ?? {};
    this.shown?.dropOverlay(OVERLAY);
    const found = at === 'found' || at === 'labelling';
    this.shown = (found && playback.store.get(frame)) || null;
    people.slice(0, MOST_FOUND).forEach(({ frames }, k) => {
      const indices = numbersOfRuns(frames.flatMap(({ runs }) => runs));
      this.shown?.mergeOverlay(OVERLAY, indices, Uint16Array.of(FOUND + k));
    });
    viewer.palette.setFound(people.map(({ color }) => color));
    viewer.setOutlined(OVERLAY, found);
    if (playback.frame) viewer.show(playback.frame);
  }

  private followRun(): void {
    if (peopleStep.peek()?.at !== 'tracking') return;
    this.run = trackingJob.peek()?.id ?? this.run;
    const ended = state.jobs.peek().find((job) => job.id === this.run && !isActive(job));
    if (!ended) return;
    this.run = null;
    if (ended.state === 'done') setStep('tracked');
    else leavePeople();
  }
}
