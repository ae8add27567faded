import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, expect, it } from 'vitest';

const SOURCE = join(import.meta.dirname, '..');
const read = (path: string) => readFileSync(join(SOURCE, path), 'utf8');
const named = (ending: string) =>
  readdirSync(SOURCE, { recursive: true, encoding: 'utf8' }).filter((path) =>
    path.endsWith(ending),
  );

const TOKENS = join('style', 'tokens.css');
/** `light.css` gives tokens other values. */
const RULES = named('.css').filter(
  (path) => !['tokens.css', 'light.css'].some((name) => path.endsWith(name)),
);

const sources = [...named('.ts'), ...named('.tsx')]
  .filter((path) => !path.endsWith('.test.ts'))
  .map(read)
  .join('\n');
/** Lines of all sheets together, as the formatter writes them. */
const MOST_LINES = 3000;

const COLOUR = /#[0-9a-f]{3,8}\b|\b(?:rgba?|hsla?|oklch|lab)\(|(?<![-\w])(?:black|white)(?![-\w])/;
/** Lengths and times. `1px` is a hairline; %, fr, ch, vw and vh follow the window or the words. */
const SIZE = /(?<![\w.-])(?!-?1px\b)-?\d*\.?\d+(?:px|em|rem|pt|ms|s)\b/;
const LAYER = /^\s*z-index: (?!var\()/;

function isLiteral(line: string): boolean {
  return COLOUR.test(line) || SIZE.test(line) || LAYER.test(line);
}

/** Return a sheet without its comments and fonts. */
function rules(path: string): string {
  return read(path).replace(/\/\*.*?\*\/|@font-face \{.*?\n\}/gs, '');
}

/** Return the lines of a sheet that hold a literal, without conditions. */
function literals(path: string): string[] {
  const lines = rules(path)
    .split('\n')
    .filter((line) => !line.startsWith('@') && isLiteral(line));
  return lines.map((line) => `${path}: ${line.trim()}`);
}

describe('the style of the page', () => {
  it('takes colours, sizes, times and layers from the tokens', () => {
    expect(RULES.flatMap(literals)).toEqual([]);
  });

  it('is no longer than 3,000 lines', () => {
    const lines = named('.css').reduce((sum, path) => sum + read(path).split('\n').length - 1, 0);
    expect(lines).toBeLessThanOrEqual(MOST_LINES);
  });

  it('has no rule for a class that no component uses', () => {
    const words = new Set(sources.match(/[\w-]+/g));
    const classes = RULES.flatMap((path) => rules(path).match(/\.[a-z][\w-]*(?=[^{};]*\{)/g) ?? []);
    expect(classes.filter((name) => !words.has(name.slice(1)))).toEqual([]);
  });

  it('uses no name that the sheets or the page do not define', () => {
    const sheets = named('.css').map(read).join('\n');
    const used = new Set([...sheets.matchAll(/var\((--[\w-]+)/g)].map(([, name]) => name!));
    const unknown = [...used].filter(
      (name) => !sheets.includes(`${name}:`) && !sources.includes(`'${name}'`),
    );
    expect(unknown).toEqual([]);
  });

  it('changes only at the windows that the tokens name', () => {
    const windows = [...read(TOKENS).matchAll(/--window-\w+: (\w+);/g)].map(([, size]) => size);
    const widths = RULES.flatMap((path) =>
      [...read(path).matchAll(/@media[^{]*/g)].flatMap(([query]) => query.match(/\d+px/g) ?? []),
    );
    expect(widths.filter((size) => !windows.includes(size))).toEqual([]);
  });

  it('moves no literal into components', () => {
    const found = named('.tsx').flatMap((path) => {
      const styles = [...read(path).matchAll(/style=\{\{.*?\}\}/gs)].map(([style]) => style);
      return styles.filter((style) => isLiteral(style)).map((style) => `${path}: ${style}`);
    });
    expect(found).toEqual([]);
  });
});
