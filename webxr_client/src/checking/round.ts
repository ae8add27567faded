/** One session of a checked headset: records its events, and ticks finished tasks. */
import { actions, bindActions } from '../store/actions';
import type { Engine } from '../engine/engine';
import type { HeadsetPictures, HeadsetSession } from '../protocol/values';
import { state } from '../store/state';
import { peek, watch } from '../store/watch';
import type { Cockpit } from '../xr/cockpit';
import type { Lesson } from '../xr/input/lessons';
import { Inputs } from './inputs';
import { CheckPanel } from './panel';
import { Pictures } from './pictures';
import { describe } from './session';
import { outcomeOf, task, tick } from './tasks';

/** Pictures after which the session is as it will be. */
const SETTLED = 10;

/** Findings of all sessions of this page. */
export class Findings {
  readonly inputs = new Inputs();
  readonly buttons = new Set<Lesson>();
  session: HeadsetSession | null = null;
  pictures: HeadsetPictures | null = null;
}

type RequestedAction = 'step' | 'undo' | 'label';

/** Requested actions, with the values that they change from before the request. */
const requested = new Map<RequestedAction, unknown>();
const CHANGES: Record<RequestedAction, () => unknown> = {
  step: () => peek(state.shown).frame,
  undo: () => peek(state.redo),
  label: () => peek(state.activeLabel),
};

function ask(what: RequestedAction): void {
  requested.set(what, CHANGES[what]());
}

/** Record requested actions from now on. */
export function noteActions(): void {
  const step = actions.time.step.bind(actions.time);
  const undo = actions.history.undo.bind(actions.history);
  const selectLabel = actions.labels.selectLabel.bind(actions.labels);
  bindActions({
    time: {
      step: (frames) => {
        ask('step');
        step(frames);
      },
    },
    history: {
      undo: () => {
        ask('undo');
        undo();
      },
    },
    labels: {
      selectLabel: (id) => {
        ask('label');
        selectLabel(id);
      },
    },
  });
}

export class Round {
  private readonly pictures = new Pictures();
  private readonly strokes = new Map<string, string>();
  private readonly stops: (() => void)[];

  constructor(
    private readonly engine: Engine,
    private readonly cockpit: Cockpit,
    private readonly session: XRSession,
    private readonly findings: Findings,
  ) {
    requested.clear();
    const { strokes, viewer } = engine;
    const panel = new CheckPanel(cockpit, findings.inputs);
    cockpit.hang(panel);
    this.stops = [
      strokes.begins.add(({ id, brush }) => this.strokes.set(id, brush.tool ?? 'paint')),
      strokes.results.add(({ id, changed }) => changed > 0 && this.changed(id)),
      cockpit.lessons.uses.add((lesson) => this.used(lesson)),
      watch([state.shown, state.redo, state.activeLabel], () => this.compare()),
      viewer.ticks.add((now, frame) => frame && this.picture(now, frame)),
    ];
  }

  /** The session has ended. */
  stop(): void {
    for (const stop of this.stops) stop();
  }

  private changed(stroke: string): void {
    const tool = this.strokes.get(stroke);
    if (tool === 'paint' || tool === 'erase') tick(tool);
  }

  private used(lesson: Lesson): void {
    this.findings.buttons.add(lesson);
    this.compare();
  }

  /** Tick requested actions that have taken effect. */
  private compare(): void {
    const came = (what: RequestedAction): boolean =>
      requested.has(what) && requested.get(what) !== CHANGES[what]();
    if (came('step')) tick('step');
    if (came('undo') && peek(state.redo) !== null) tick('undo');
    // With a pad it is the pad that is tried.
    const pads = this.cockpit.pointers.bodies.some(({ pointer }) => pointer.device.pad !== 'none');
    if (came('label') && (this.findings.buttons.has('label') || !pads)) tick('label');
  }

  private picture(now: number, frame: XRFrame): void {
    const { engine, cockpit, session, findings, pictures } = this;
    const { viewer } = engine;
    const space = viewer.renderer.xr.getReferenceSpace();
    if (space) findings.inputs.note(session.inputSources, frame, space);
    if (cockpit.frames === SETTLED) this.begin();
    pictures.note(now, peek(state.playing));
    if (pictures.enough && outcomeOf('play').verdict === 'unknown') this.played();
    if (cockpit.locomotion.moves > 0) tick('go');
  }

  private begin(): void {
    const { engine, cockpit, session, findings } = this;
    const found = describe(session, engine.viewer, cockpit.mode, cockpit.floor);
    void found.then((facts) => (findings.session = facts));
    if (task.peek()?.name === 'play') actions.time.play();
  }

  private played(): void {
    actions.time.pause();
    this.findings.pictures = this.pictures.sum(this.session);
    tick('play');
  }
}
