/** For tests: a person with input sources, and all that turns their gestures into edits, without a GPU. */
import { Object3D, Vector3 } from 'three';
import { vi } from 'vitest';
import { frameOf, wall } from '../../cloud/points/testing';
import type { Engine } from '../../engine/engine';
import type { Ask, ClientMessage, Label } from '../../protocol/messages';
import {
  bindActions,
  type LabelActions,
  type TimeActions,
  type ToolActions,
  type TrackingActions,
} from '../../store/actions';
import { state } from '../../store/state';
import { brushNow } from '../../tools/brush';
import { ObjectTool } from '../../tools/object';
import { Strokes } from '../../tools/strokes';
import { roomWay } from '../../tools/ways';
import { Buttons } from '../input/buttons';
import { Lessons } from '../input/lessons';
import { UpDown } from '../input/up-down';
import { answersAt } from '../painting/answers';
import { Painter } from '../painting/painter';
import { Place } from '../painting/place';
import { TestInputs, type TestSource } from './sources';

/** Milliseconds from one picture to the next. */
const PICTURE_MS = 20;
/** Points of the levels of every object. */
const LEVELS = [10, 40, 90];
/** A stand-in for drawn objects that accepts all calls. */
const DRAWN: unknown = new Proxy({}, { get: () => () => true });

export class Bench {
  readonly inputs: TestInputs;
  /** Messages to the server, the newest last. */
  readonly sent: ClientMessage[] = [];
  /** Names of the actions that were asked for. */
  readonly acted: string[] = [];
  readonly painter: Painter;
  readonly upDown: UpDown;
  private readonly place: Place;
  private readonly buttons: Buttons;
  private readonly strokes: Strokes;
  private readonly objects: ObjectTool;
  private readonly unbind: () => void;
  private now = 0;

  constructor(...sources: TestSource[]) {
    this.inputs = new TestInputs(...sources);
    state.sequence.value = { id: 'a', frames: 6, fps: 30, shift: [0, 0, 0], sensors: [] } as never;
    state.palette.value = [1, 2, 3].map(
      (id) => ({ id, color: '#5ea2ff', visible: true, locked: false }) as Label,
    );
    state.activeLabel.value = 1;
    state.tool.value = 'paint';
    state.object.value = null;
    const frame = frameOf(wall(20, 1000));
    const send = (message: ClientMessage): void => void this.sent.push(structuredClone(message));
    const nothing = vi.fn();
    this.strokes = new Strokes({ send, seen: () => true, hidden: () => [], layers: () => [], locked: () => false, changed: nothing, now: () => this.now }); // prettier-ignore
    this.objects = new ObjectTool({
      send, strokes: this.strokes, frame: () => frame, shift: () => [0, 0, 0],
      brush: () => brushNow(roomWay(), 0.05), changed: nothing, later: () => nothing,
    }); // prettier-ignore
    const [world, room] = [new Object3D(), new Object3D()];
    const viewer = { world, room, palette: { isShown: () => true }, uniforms: DRAWN };
    const engine = {
      viewer, strokes: this.strokes, objects: this.objects, regions: DRAWN, playback: { frame },
      beginStroke: (brush: never) => this.strokes.begin(frame, brush, [0, 0, 0]),
    } as unknown as Engine; // prettier-ignore
    this.place = new Place(engine.viewer);
    this.painter = new Painter(engine, this.place, nothing);
    this.buttons = new Buttons(new Lessons(), () => this.acted.push('panels'));
    this.upDown = new UpDown({
      answers: (hand) => answersAt(this.place, hand),
      marked: nothing,
      taken: nothing,
      level: (step) => this.painter.stepLevel(step),
    });
    this.unbind = this.bind();
    this.go(2);
  }

  /** Record all actions; actions of labels, objects and history change the state as the engine does. */
  private bind(): () => void {
    const { objects, sent } = this;
    const travels = (type: 'undo' | 'redo') => () => sent.push({ type, id: '' });
    const note =
      (name: string, does?: (...values: never[]) => unknown) =>
      (...values: never[]): unknown => {
        this.acted.push(name);
        return does?.(...values);
      };
    const select = (id: number): void => {
      state.activeLabel.value = id;
      objects.end();
    };
    const noted = (names: readonly string[]): object =>
      Object.fromEntries(names.map((name) => [name, note(name)]));
    return bindActions({
      time: noted(TIME),
      labels: { ...noted(LABELS), selectLabel: note('selectLabel', select) },
      tools: {
        ...noted(TOOLS),
        completeObject: note('completeObject', () => objects.accept()) as () => boolean,
        stepObject: note('stepObject', (n) => objects.step(n)) as (levels: number) => boolean,
        endObject: note('endObject', () => objects.end()),
      },
      history: { undo: note('undo', travels('undo')), redo: note('redo', travels('redo')) },
      tracking: noted(TRACKING),
    });
  }

  /** Some pictures; questions about objects are answered between two. */
  go(pictures = 1): void {
    const { inputs, painter } = this;
    for (let i = 0; i < pictures; i++) {
      this.now += PICTURE_MS;
      inputs.advance(PICTURE_MS / 1000);
      this.place.update();
      const { brush, other } = inputs.pointers;
      this.upDown.update(brush, this.now);
      this.buttons.update(brush, other, Float64Array.of(PICTURE_MS / 1000), this.now);
      painter.update(brush, other, new Vector3(), false, this.now);
      painter.completion.update(false, this.now);
      this.answer();
    }
  }

  private answer(): void {
    const request = this.sent.findLast((message): message is Ask => message.type === 'ask');
    if (!request) return;
    const candidates = LEVELS.map((points, level) => {
      const runs = new Uint8Array(Uint32Array.of(10, points).buffer);
      return { id: `${request.id}-${level}`, level, score: 0.5, points, runs };
    });
    const { id } = request;
    this.objects.onCandidates({ type: 'candidates', id, frame: 0, first: 0, ready: true, candidates }); // prettier-ignore
  }

  /** Press or release the trigger of the brush. */
  trigger(down: boolean): void {
    const brush = this.inputs.pointers.brush!;
    const source = brush.source as unknown as TestSource;
    const button = source.gamepad?.buttons[brush.device.trigger];
    if (button) button.value = down ? 1 : 0;
    else this.inputs.select(source, down);
    this.go(5);
  }

  /** Paint a stroke and wait until its object is offered. */
  stroke(): void {
    this.trigger(true);
    this.trigger(false);
  }

  /** Changes of labels asked of the server. */
  get edits(): string[] {
    return this.sent.flatMap(({ type }) => (EDITS.includes(type) ? type : []));
  }

  dispose(): void {
    this.unbind();
    this.painter.dispose();
    vi.unstubAllGlobals();
  }
}

const EDITS = ['stroke_begin', 'undo', 'redo', 'track'];
/** Actions besides that a controller could ask for. */
const TIME: readonly (keyof TimeActions)[] =
  ['togglePlay', 'play', 'pause', 'step', 'nextDoubtful', 'seek']; // prettier-ignore
const TOOLS: readonly (keyof ToolActions)[] =
  ['toggleEraser', 'setRadius', 'nudgeRadius', 'setTool', 'setShape']; // prettier-ignore
const LABELS: readonly (keyof LabelActions)[] =
  ['deleteLabel', 'clearLabels', 'lastLabel', 'selectNthLabel']; // prettier-ignore
const TRACKING: readonly (keyof TrackingActions)[] =
  ['track', 'acceptFrame', 'acceptStretch', 'clearStretch', 'continueRun']; // prettier-ignore
