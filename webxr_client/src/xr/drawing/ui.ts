/**
 * Drawing of panels in the room: a canvas, and the places on it that answer to a ray.
 * Everything is drawn anew when something changed; places are noted while drawing.
 */
import { hexByte, inkOn } from '../../common/colors';
import { type IconName, ICONS } from '../../common/icons';
import { ellipsis } from '../../panels/timeline/draw';

export const FONT = '"Inter Variable", system-ui, sans-serif';

/** Contrast on `back` is above 7 for text, above 4.5 for quiet text. */
export const INK = {
  back: '#0c1014',
  on: '#1c416d',
  /** Text on a button that is on. */
  onText: '#bcd7ff',
  line: '#38424e',
  text: '#f2f5f9',
  quiet: '#b4bec9',
  accent: '#8bbcff',
  bad: '#ff7b72',
  good: '#4cc38a',
  /** It cannot be pressed now. */
  off: '#8d97a5',
  warn: '#ffc966',
} as const;

/**
 * A panel is dark glass: the room shines through its back.  Opacities of the back, of the white on
 * raised parts and on the rim, and of the whole panel behind nearer points or during a stroke.
 */
export const GLASS = { back: 0.9, raised: 0.08, rim: 0.34, veil: 0.3 } as const;

/** A colour with an opacity, as the canvas takes it. */
function veiled(color: string, opacity: number): string {
  return color + hexByte(255 * opacity);
}

export const RAISED = veiled('#ffffff', GLASS.raised);
const BACK = veiled(INK.back, GLASS.back);
const RIM = veiled('#ffffff', GLASS.rim);
/** Ems: radius of a panel's corners and of its parts, and the width of the rim. */
const [CORNER, ROUND, EDGE] = [1, 0.5, 0.07];
/** Opacity of the colour of labels that are hidden in the room. */
const FADED = 0.3;

export interface Area {
  readonly name: string;
  readonly x: number;
  readonly y: number;
  readonly w: number;
  readonly h: number;
  /** Press, with where in the area, 0..1. */
  readonly act?: ((x: number, y: number) => void) | undefined;
  /** While pressed, also outside of the area; then clamped. */
  readonly drag?: ((x: number, y: number) => void) | undefined;
  readonly release?: (() => void) | undefined;
  /** Carries the panel while it is held. */
  readonly moves?: boolean;
  /** Too large to light up under the ray. */
  readonly plain?: boolean;
}

/** The light on the ray's target, and its opacity, with legible text below it. */
export const LIGHT = { color: '#8bbcff', opacity: 0.14 } as const;

export interface ButtonLook {
  icon?: IconName;
  text?: string;
  swatch?: string;
  /** All of it has this colour: a chip. */
  fill?: string;
  faded?: boolean;
  /** The icon is above the text. */
  tile?: boolean;
  /** Quiet words at the right end. */
  note?: string;
  on?: boolean;
  disabled?: boolean;
  strong?: boolean;
  align?: 'left' | 'center';
}

/** A button of a strip. */
export type Entry = readonly [look: ButtonLook, act: () => void];

/** Colours of a button's back, if it has one, and of the words on it. */
function buttonColors({ on, strong, disabled }: ButtonLook): [back: string | null, words: string] {
  const words = disabled ? INK.off : on ? INK.onText : INK.text;
  return [on ? INK.on : strong ? RAISED : null, words];
}

function chipColors(fill: string, { faded }: ButtonLook): [back: string, words: string] {
  return faded ? [veiled(fill, FADED), INK.text] : [fill, inkOn(fill)];
}

const paths = new Map<IconName, Path2D>();

export class Ui {
  readonly areas: Area[] = [];

  constructor(
    readonly pen: CanvasRenderingContext2D,
    readonly width: number,
    readonly height: number,
    /** Pixels of normal text. */
    readonly em: number,
  ) {}

  /** Wipe it all, and lay a plate where something is to be drawn. */
  begin(x = 0, y = 0, w = this.width, h = this.height): void {
    this.areas.length = 0;
    this.pen.clearRect(0, 0, this.width, this.height);
    this.box(x, y, w, h, BACK, CORNER);
    // A rim: where one panel is seen before another, each must end somewhere.
    this.rim(x, y, w, h, RIM, EDGE, CORNER);
  }

  /** Note a place that answers. */
  area(area: Area): void {
    this.areas.push(area);
  }

  /** Number of the topmost area at a place, or −1. */
  find(place: Float64Array): number {
    const px = place[0]!;
    const py = place[1]!;
    for (let i = this.areas.length - 1; i >= 0; i--) {
      const { x, y, w, h } = this.areas[i]!;
      if (px >= x && px <= x + w && py >= y && py <= y + h) return i;
    }
    return -1;
  }

  text(
    text: string,
    x: number,
    y: number,
    look: {
      color?: string;
      size?: number;
      weight?: number;
      align?: CanvasTextAlign;
      width?: number;
    } = {},
  ): void {
    const { pen, em } = this;
    pen.font = `${look.weight ?? 500} ${(look.size ?? 1) * em}px ${FONT}`;
    pen.fillStyle = look.color ?? INK.text;
    pen.textAlign = look.align ?? 'left';
    pen.textBaseline = 'middle';
    pen.fillText(look.width === undefined ? text : ellipsis(pen, text, look.width), x, y);
  }

  icon(name: IconName, x: number, y: number, size: number, color: string): void {
    const { pen } = this;
    let path = paths.get(name);
    if (!path) {
      path = new Path2D(ICONS[name]);
      paths.set(name, path);
    }
    pen.save();
    pen.translate(x, y);
    pen.scale(size / 16, size / 16);
    pen.strokeStyle = color;
    pen.lineWidth = 1.5;
    pen.lineCap = pen.lineJoin = 'round';
    pen.stroke(path);
    pen.restore();
  }

  box(x: number, y: number, w: number, h: number, color: string, round = ROUND): void {
    this.pen.fillStyle = color;
    this.pen.beginPath();
    this.pen.roundRect(x, y, w, h, this.em * round);
    this.pen.fill();
  }

  /** Draw a line of so many ems just inside an outline. */
  rim(
    x: number,
    y: number,
    w: number,
    h: number,
    color: string,
    wide: number,
    round = ROUND,
  ): void {
    const { pen, em } = this;
    const line = em * wide;
    pen.beginPath();
    pen.roundRect(x + line / 2, y + line / 2, w - line, h - line, em * round - line / 2);
    pen.lineWidth = line;
    pen.strokeStyle = color;
    pen.stroke();
  }

  /** Lay buttons side by side on one plate, in so many columns of rows of height `h`, as tiles. */
  strip(
    x: number,
    y: number,
    w: number,
    h: number,
    entries: readonly Entry[],
    columns = entries.length,
  ): void {
    const wide = w / columns;
    this.box(x, y, w, h * Math.ceil(entries.length / columns), RAISED, ROUND);
    entries.forEach(([look, act], i) => {
      const [column, line] = [i % columns, Math.floor(i / columns)];
      this.button(x + column * wide, y + line * h, wide, h, { tile: true, ...look }, act);
    });
  }

  button(
    x: number,
    y: number,
    w: number,
    h: number,
    look: ButtonLook,
    act?: (x: number, y: number) => void,
  ): void {
    const usable = act && !look.disabled;
    if (usable) this.area({ name: look.text ?? look.icon ?? look.swatch ?? '', x, y, w, h, act });
    const [fill, color] = look.fill ? chipColors(look.fill, look) : buttonColors(look);
    if (fill) this.box(x, y, w, h, fill);
    if (look.fill && look.on) this.rim(x, y, w, h, INK.text, 0.2);
    if (look.tile) this.tile(x, y, w, h, look, color);
    else this.row(x, y, w, h, look, color);
  }

  /** Draw an icon and the word below it. */
  private tile(
    x: number,
    y: number,
    w: number,
    h: number,
    { icon, text }: ButtonLook,
    color: string,
  ): void {
    const { em } = this;
    const size = em * 1.3;
    const middle = x + w / 2;
    const top = y + (h - size - (text ? em * 1.05 : 0)) / 2;
    if (icon) this.icon(icon, middle - size / 2, top, size, color);
    const at = icon ? top + size + em * 0.65 : y + h / 2;
    if (text) this.text(text, middle, at, { color, align: 'center', width: w - em * 0.3 });
  }

  /** Draw swatch, icon and text side by side. */
  private row(x: number, y: number, w: number, h: number, look: ButtonLook, color: string): void {
    const { em, pen } = this;
    const size = em * 1.25;
    const gap = em * 0.45;
    const marks = (look.icon ? size + gap : 0) + (look.swatch ? size + gap : 0);
    const text = look.text ?? '';
    const noted = look.note ? this.note(look, x + w - em * 0.5, y + h / 2, w * 0.4) : 0;
    pen.font = `500 ${em}px ${FONT}`;
    const room = w - marks - noted - em * 0.8;
    const wide = text ? Math.min(room, pen.measureText(text).width) : -gap;
    const pad = em * 0.5;
    let left = look.align === 'left' ? x + pad : x + Math.max(pad * 0.5, (w - marks - wide) / 2);
    if (look.swatch) {
      this.box(left, y + (h - size) / 2, size, size, look.swatch);
      left += size + gap;
    }
    if (look.icon) {
      this.icon(look.icon, left, y + (h - size) / 2, size, color);
      left += size + gap;
    }
    if (text) this.text(text, left, y + h / 2, { color, width: room });
  }

  /** Write quiet words that end at `right`; returns the room that they take. */
  private note({ note, on }: ButtonLook, right: number, y: number, width: number): number {
    const { em, pen } = this;
    const text = note ?? '';
    this.text(text, right, y, { color: on ? INK.onText : INK.quiet, align: 'right', width });
    return Math.min(width, pen.measureText(text).width) + em * 0.5;
  }

  /** `share` 0..1. */
  slider(
    x: number,
    y: number,
    w: number,
    h: number,
    name: string,
    shown: string,
    share: number,
    set: (share: number) => void,
  ): void {
    const { em } = this;
    this.text(name, x, y + h * 0.28, { color: INK.quiet });
    this.text(shown, x + w, y + h * 0.28, { align: 'right' });
    const middle = y + h * 0.75;
    // The words above the bar answer too: a bar alone is too low to be met.
    this.area({ name, x, y, w, h, act: set, drag: set });
    this.box(x, middle - em * 0.14, w, em * 0.28, INK.line);
    this.box(x, middle - em * 0.14, Math.max(em * 0.3, w * share), em * 0.28, INK.accent);
    this.pen.fillStyle = INK.text;
    this.pen.beginPath();
    this.pen.arc(x + w * share, middle, em * 0.42, 0, 7);
    this.pen.fill();
  }

  check(
    x: number,
    y: number,
    w: number,
    h: number,
    name: string,
    on: boolean,
    set: (on: boolean) => void,
  ): void {
    const { em } = this;
    this.area({ name, x, y, w, h, act: () => set(!on) });
    const size = em * 1.1;
    const top = y + (h - size) / 2;
    this.box(x + em * 0.4, top, size, size, on ? INK.accent : INK.line, ROUND / 2);
    if (on) this.icon('check', x + em * 0.45, top + em * 0.05, em, INK.back);
    this.text(name, x + em * 2, y + h / 2, { width: w - em * 2.2 });
  }
}
