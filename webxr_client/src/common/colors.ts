/** Label colours: far apart, light enough to be read on the dark room. */

export const LABEL_COLORS = [
  '#ff5d5d',
  '#ffb02e',
  '#ffe14d',
  '#8ddf4a',
  '#2fce8f',
  '#2fd5e0',
  '#4aa8ff',
  '#8c86ff',
  '#c46bff',
  '#ff6ec7',
  '#ff8a65',
  '#d6c08c',
  '#a4b85c',
  '#5fb7a6',
  '#86b6d9',
  '#d59ad0',
] as const;

/** Colours for colour-blind people: Okabe and Ito (2008), and five further ones. */
export const SAFE_COLORS = [
  '#e69f00',
  '#56b4e9',
  '#009e73',
  '#f0e442',
  '#0072b2',
  '#d55e00',
  '#cc79a7',
  '#96ffff',
  '#784b4b',
  '#b4c3a5',
  '#a569ff',
  '#d2ffb4',
] as const;

export type Rgb = readonly [number, number, number];

/** "#rrggbb" → 0..255 each. */
export function parseColor(color: string): Rgb {
  const value = Number.parseInt(color.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}

/** 0..255 → two hexadecimal digits. */
export function hexByte(value: number): string {
  return Math.round(value).toString(16).padStart(2, '0');
}

function linear(channel: number): number {
  const value = channel / 255;
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
}

/** Relative luminance of WCAG 2, 0..1. */
export function luminance(color: string): number {
  const [red, green, blue] = parseColor(color);
  return 0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue);
}

/** Contrast ratio of WCAG 2, 1..21. */
export function contrast(one: string, other: string): number {
  const first = luminance(one);
  const second = luminance(other);
  return (Math.max(first, second) + 0.05) / (Math.min(first, second) + 0.05);
}

/** Black or white, whichever is easier to read on `color`. */
export function inkOn(color: string): '#07131f' | '#ffffff' {
  return contrast(color, '#07131f') >= contrast(color, '#ffffff') ? '#07131f' : '#ffffff';
}

/** Oklab, where distance is close to the perceived difference (Björn Ottosson, 2020). */
export function oklab([r, g, b]: Rgb): Rgb {
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}

function fromOklab(lightness: number, a: number, b: number): string {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const channels = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  return `#${channels.map(encoded).join('')}`;
}

/** Two hexadecimal digits of a linear channel. */
function encoded(value: number): string {
  const within = Math.min(1, Math.max(0, value));
  const light = within <= 0.0031308 ? within * 12.92 : 1.055 * within ** (1 / 2.4) - 0.055;
  return hexByte(light * 255);
}

/** Visible difference of two colours; 0 is the same. */
export function difference(one: string, other: string): number {
  return apart(oklab(lightOf(one)), oklab(lightOf(other)));
}

/** Distance of two colours in Oklab. */
export function apart(a: Rgb, b: Rgb): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/** Linear red, green and blue, 0..1 each. */
export function lightOf(color: string): Rgb {
  return parseColor(color).map(linear) as unknown as Rgb;
}

/** Lightness and chroma of further colours, in Oklab, and how many hues of each. */
const FURTHER = [[0.72, 0.13], [0.82, 0.1], [0.66, 0.16]] as const; // prettier-ignore
const HUES = 24;

function furtherColors(): string[] {
  return FURTHER.flatMap(([lightness, chroma]) =>
    Array.from({ length: HUES }, (_, k) => {
      const hue = (2 * Math.PI * k) / HUES;
      return fromOklab(lightness, chroma * Math.cos(hue), chroma * Math.sin(hue));
    }),
  );
}

/** The colour of the set that is farthest from all that are taken; of further ones when all are. */
export function suggestColor(
  taken: readonly string[],
  set: readonly string[] = LABEL_COLORS,
): string {
  const used = new Set(taken.map((color) => color.toLowerCase()));
  const all = set.every((color) => used.has(color));
  const distance = (color: string): number =>
    Math.min(Infinity, ...taken.map((other) => difference(color, other)));
  const choices: readonly string[] = all ? furtherColors() : set;
  return choices.reduce((best, color) => (distance(color) > distance(best) ? color : best));
}

/** "pin 2" after "pin 1": counts on from the names that exist in a category. */
export function suggestName(category: string, names: readonly string[]): string {
  const base = category.trim() || 'label';
  const numbers = names
    .map((name) => new RegExp(`^${escapeRegExp(base)}\\s*(\\d+)$`, 'i').exec(name.trim())?.[1])
    .map((digits) => (digits === undefined ? 0 : Number(digits)));
  return `${base} ${Math.max(0, ...numbers) + 1}`;
}

function escapeRegExp(text: string): string {
  return text.replace(/[.*+?^${}()|[\]\\]/g, '\\$&');
}
