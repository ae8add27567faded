/**
 * The object tool: asks the server for candidates of a click, steps through their levels, and
 * takes one.  Mouse, controller and hand use it alike.
 */
import type { PointerSample, Vec } from '../store/types';
import type { CloudFrame } from '../cloud/points/frame';
import { PREVIEW } from '../cloud/picture/palette';
import { DELETED } from '../cloud/points/piece';
import type { Brush, Candidates, ClientMessage, Sample } from '../protocol/messages';
import { numbersOf } from '../protocol/codec';
import { Listeners } from '../store/listeners';
import { state } from '../store/state';
import { sourceSample } from './path';
import { preparation } from './preparation';
import { mostLike, samePlace } from './likeness';
import {
  shownOf,
  type Clicks,
  type Offer,
  type Purpose,
  type Question,
  type TakenObject,
} from './offers';
import type { Strokes } from './strokes';

/** Overlay of the points that a click would take. */
const OVERLAY = 'object';
/** A level that was chosen after the click is taken once the wheel has rested, milliseconds. */
const REST_MS = 300;
/** Clicks of a stroke that is completed. */
const MOST_OF_STROKE = 5;

export interface ObjectDeps {
  readonly send: (message: ClientMessage) => void;
  readonly strokes: Strokes;
  readonly frame: () => CloudFrame | null;
  /** Source minus local coordinates. */
  readonly shift: () => Vec;
  /** Brush of a click as a message; null when a click may not paint. */
  readonly brush: () => Brush | null;
  /** Called when the picture must be drawn again. */
  readonly changed: () => void;
  readonly later: (run: () => void, milliseconds: number) => () => void;
}

export class ObjectTool {
  private offer: Offer | null = null;
  private taken: TakenObject | null = null;
  private pending: Question | null = null;
  /** The newest place pointed at while an answer was awaited. */
  private waiting: Sample | null = null;
  private rest: (() => void) | null = null;
  /** Questions of strokes that the server may refuse as stale, to ask again. */
  private readonly sent = new Map<string, Question>();
  /** The stroke that `complete` is about. */
  private replaces: string | null = null;

  /** Called with every click, and whether it removes. */
  readonly clicks = new Listeners<boolean>();

  constructor(private readonly deps: ObjectDeps) {}

  /** Show the points that a click at the pointer would take. */
  hover(pointed: PointerSample): void {
    if (this.offer?.question.purpose === 'complete') return;
    const sample = this.sampleOf(pointed);
    if (this.pending) {
      if (this.pending.purpose === 'hover') this.waiting = sample;
      return;
    }
    if (this.offer && samePlace(this.offer.question.positives.at(-1), sample)) return;
    if (this.taken) return;
    this.ask({ positives: [sample], negatives: [] }, 'hover', this.chosenPoints());
  }

  /** The pointer left the recording. */
  leave(): void {
    this.waiting = null;
    if (this.offer?.question.purpose === 'hover' && !this.taken) this.drop();
  }

  /** Walk through the levels; false when none are shown. */
  step(levels: number): boolean {
    const { offer } = this;
    if (!offer || offer.candidates.length === 0) return false;
    offer.level = Math.min(offer.candidates.length - 1, Math.max(0, offer.level + levels));
    offer.chosen = true;
    this.show();
    if (!this.taken) return true;
    this.rest?.();
    const { taken } = this;
    this.rest = this.deps.later(() => {
      this.rest = null;
      if (this.taken) this.ask(taken, 'take', shownOf(offer), taken.previous);
    }, REST_MS);
    return true;
  }

  /**
   * Take the shown points; after that, add the place under the pointer, or `remove` it.  The eraser
   * also removes from a painted object.
   */
  click(pointed: PointerSample, remove = false): void {
    const sample = this.sampleOf(pointed);
    const { taken, offer } = this;
    this.clicks.run(remove);
    if (taken && taken.frame === this.deps.frame()) {
      remove ||= taken.brush.tool === 'paint' && this.deps.brush()?.tool === 'erase';
      // A click that is not answered yet counts: the next one must not lose it.
      const { positives, negatives } = this.pending?.purpose === 'take' ? this.pending : taken;
      const clicks = remove
        ? { positives, negatives: [...negatives, sample] }
        : { positives: [...positives, sample], negatives };
      this.ask(clicks, 'take');
      return;
    }
    if (remove) return;
    const here = offer?.question.frame === this.deps.frame() && offer.question.purpose === 'hover';
    if (here && samePlace(offer.question.positives[0], sample)) this.take(offer);
    else this.ask({ positives: [sample], negatives: [] }, 'take');
  }

  /** A stroke was drawn: offer to complete it to the object. */
  complete(samples: readonly PointerSample[], edit: string): void {
    this.end();
    this.replaces = edit;
    const step = Math.max(1, Math.ceil(samples.length / MOST_OF_STROKE));
    const chosen = samples.filter((_, i) => i % step === 0).slice(0, MOST_OF_STROKE);
    if (chosen.length === 0) return;
    this.ask({ positives: chosen.map((one) => this.sampleOf(one)), negatives: [] }, 'complete');
  }

  /** Accept the object that `complete` offers; false when it offers none. */
  accept(): boolean {
    const { offer, taken } = this;
    if (taken || offer?.question.purpose !== 'complete' || !offer.candidates.length) return false;
    this.take(offer);
    return true;
  }

  /** Whether something is taken or offered that Escape would end. */
  get active(): boolean {
    return this.taken !== null || this.offer?.question.purpose === 'complete';
  }

  /** Whether levels are still to come: the wheel, which walks through them, does nothing else. */
  get waits(): boolean {
    if (state.connection.peek().state !== 'online') return false;
    return preparation() !== null || (this.pending !== null && this.offer === null);
  }

  /** End the taken object: further clicks begin another one. */
  end(): boolean {
    const going = this.active;
    this.rest?.();
    this.rest = null;
    this.taken = null;
    this.replaces = null;
    this.restart();
    this.drop();
    return going;
  }

  /** Change of tool: brush and eraser refine the taken object, other tools end it. */
  onToolChange(tool: string): void {
    if (!this.taken || (tool !== 'paint' && tool !== 'erase')) this.end();
  }

  /** The link is back: questions on the old one get no answer. */
  restart(): void {
    this.pending = null;
    this.waiting = null;
    state.objectAsked.value = false;
  }

  // ── the server's messages ──────────────────────────────────────────────────────────────────

  onCandidates(message: Candidates): void {
    const question = this.pending;
    if (question?.id !== message.id) return;
    this.pending = null;
    this.dropOverlay();
    const candidates = message.candidates.map(({ id, runs }) => ({ id, indices: numbersOf(runs) }));
    const like = question.like && mostLike(candidates, question.like);
    // Near points alone do not show the extent of an object: its smallest part is the safest choice.
    const first = message.ready || question.purpose !== 'hover' ? message.first : 0;
    const level = like ?? Math.max(0, Math.min(first, candidates.length - 1));
    this.offer = { question, candidates, ready: message.ready, level, chosen: like !== null };
    if (question.purpose === 'take' && message.candidates.length > 0) this.take(this.offer);
    else this.show();
    const next = this.waiting;
    this.waiting = null;
    if (next && !this.taken)
      this.ask({ positives: [next], negatives: [] }, 'hover', this.chosenPoints());
  }

  /** A frame is prepared: ask again, because its candidates may be better now. */
  onPrepared(frame: number): void {
    const { offer } = this;
    if (!offer || offer.ready || offer.question.frame.index !== frame || this.pending) return;
    const hovers = offer.question.purpose === 'hover' && !this.taken;
    if (hovers) this.ask(offer.question, 'hover', shownOf(offer));
    else {
      // Points taken stay as they are; the next click is answered from the whole frame.
      offer.ready = true;
      this.publishState();
    }
  }

  /** Labels of a frame changed, and with them the candidates of a click there: ask again. */
  onLabels(frame: number): void {
    const { pending, offer } = this;
    const question = pending ?? offer?.question;
    if (this.taken || question?.purpose !== 'hover' || question.frame.index !== frame) return;
    if (pending) this.waiting ??= pending.positives[0]!;
    else this.ask(question, 'hover', shownOf(offer!));
  }

  /** The server refused a question or a stroke; true when it was ours and is asked again. */
  onError(about: string, status: number): boolean {
    if (this.pending?.id === about) {
      this.pending = null;
      this.drop();
      return false;
    }
    const question = this.sent.get(about);
    this.sent.delete(about);
    if (!question) return false;
    this.taken = null;
    if (status !== 409) return false;
    // The points have been painted since: repeat the question with the same clicks.
    this.ask(question, 'take', question.like);
    return true;
  }

  /** A stroke is durable. */
  onResult(id: string): void {
    this.sent.delete(id);
  }

  // ── asking and taking ──────────────────────────────────────────────────────────────────────

  private ask(
    { positives, negatives }: Clicks,
    purpose: Purpose,
    like: Uint32Array | null = null,
    previous = this.taken?.candidate ?? '',
  ): void {
    const frame = this.deps.frame();
    const brush = this.deps.brush() && (this.taken?.brush ?? this.deps.brush());
    if (!frame || !brush) return;
    const id = crypto.randomUUID();
    this.pending = { id, frame, brush, purpose, like, previous, positives, negatives };
    const [samples, without] = [[...positives], [...negatives]];
    this.deps.send({
      type: 'ask',
      id,
      frame: frame.index,
      brush,
      samples,
      negatives: without,
      previous,
    });
    state.objectAsked.value = this.waits;
  }

  private take(offer: Offer): void {
    const { question, level } = offer;
    const chosen = offer.candidates[level];
    if (!chosen) return;
    const { frame, positives, negatives, previous } = question;
    const brush: Brush = {
      ...question.brush,
      candidate: chosen.id,
      negatives: [...negatives],
      previous,
    };
    const replaced = this.taken?.edit ?? this.replaces;
    if (replaced !== null) brush.replaces = replaced;
    this.replaces = null;
    // A preview still awaited would be laid over the points taken.
    this.pending = null;
    this.waiting = null;
    this.dropOverlay();
    const [x, y, z] = this.deps.shift();
    const stroke = this.deps.strokes.begin(frame, brush, [x, y, z]);
    for (const { origin, direction } of positives) {
      const [a, b, c] = origin;
      stroke.add({
        origin: [a - x, b - y, c - z],
        direction: direction as [number, number, number],
      });
    }
    const edit = stroke.id;
    frame.setOverlay(edit, { indices: chosen.indices, values: this.valueOf(brush), edit });
    stroke.end();
    this.sent.set(edit, { ...question, like: chosen.indices });
    const candidate = chosen.id;
    const tool = question.brush;
    this.taken = { frame, edit, candidate, previous, positives, negatives, brush: tool };
    this.publishState();
    this.deps.changed();
  }

  /** Points of a level that a person has chosen: nearby it stays. */
  private chosenPoints(): Uint32Array | null {
    return this.offer?.chosen ? shownOf(this.offer) : null;
  }

  private sampleOf(pointed: PointerSample): Sample {
    return sourceSample(pointed, this.deps.shift());
  }

  // ── showing ────────────────────────────────────────────────────────────────────────────────

  private valueOf({ tool, label }: Brush): Uint16Array {
    return Uint16Array.of(tool === 'paint' ? (label ?? 0) : tool === 'delete' ? DELETED : 0);
  }

  /** Points that would be painted are lighter than their label, and have an edge. */
  private previewOf(brush: Brush): Uint16Array {
    return brush.tool === 'paint' ? Uint16Array.of(PREVIEW) : this.valueOf(brush);
  }

  private show(): void {
    const { offer } = this;
    const chosen = offer?.candidates[offer.level];
    if (offer && chosen) {
      const { frame, brush } = offer.question;
      // A stroke's points show as painted while its object is offered.
      const completes = offer.question.purpose === 'complete' && !this.taken;
      const label = brush.label ?? 0;
      this.dropOverlay();
      const indices = completes
        ? chosen.indices.filter((point) => frame.labelOf(point) !== label)
        : chosen.indices;
      frame.setOverlay(OVERLAY, { indices, values: this.previewOf(brush) });
    } else this.dropOverlay();
    this.publishState();
    this.deps.changed();
  }

  private publishState(): void {
    const { offer } = this;
    const [shown, taken] = [offer?.candidates[offer.level], this.taken !== null];
    state.objectAsked.value = false;
    state.object.value = offer && {
      levels: offer.candidates.length,
      level: offer.level,
      points: shown?.indices.length ?? 0,
      ready: offer.ready,
      taken: shown !== undefined && taken,
      completes: shown !== undefined && offer.question.purpose === 'complete' && !taken,
    };
  }

  private drop(): void {
    this.dropOverlay();
    this.offer = null;
    this.publishState();
    this.deps.changed();
  }

  private dropOverlay(): void {
    this.offer?.question.frame.dropOverlay(OVERLAY);
  }
}
