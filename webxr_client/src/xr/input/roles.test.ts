import { expect, it } from 'vitest';
import { KINDS } from './kinds';
import { rolesOf, type Present } from './roles';
import type { Side } from '../../store/xr-settings';

type One = Present & { readonly name: string };

/** `right controller`, `touch`; a `tracked` one does not press. */
function present(words: string): One {
  const [, tracked, side, name] = /^(tracked )?(?:(left|right) )?(.*)$/.exec(words)!;
  const rank = KINDS.findIndex((kind) => kind.name === name);
  const { momentary, holds } = KINDS[rank]!;
  const primary = tracked === undefined;
  return {
    name: words,
    rank,
    side: (side as Side | undefined) ?? 'none',
    momentary,
    holds,
    primary,
  };
}

const CONTROLLERS = ['left controller', 'right controller'];
const HANDS = ['left hand', 'right hand'];

it.each<[what: string, there: string[], wished: Side, brush: string, other: string, palette: string]>([
  ['two controllers', CONTROLLERS, 'right', 'right controller', 'left controller', 'left controller'],
  ['left-handed', CONTROLLERS, 'left', 'left controller', 'right controller', 'right controller'],
  ['a right one alone', ['right controller'], 'right', 'right controller', '', ''],
  ['a left one alone', ['left controller'], 'right', 'left controller', '', ''],
  ['one without a side', ['controller'], 'left', 'controller', '', ''],
  ['two without sides', ['controller', 'controller'], 'right', 'controller', 'controller', 'controller'],
  ['hands beside controllers', [...HANDS, ...CONTROLLERS], 'right', 'right controller', 'left controller', 'left controller'],
  ['a hand beside the only controller', ['right hand', 'right controller'], 'right', 'right controller', '', ''],
  ['a hand and a controller', ['right controller', 'left hand'], 'right', 'right controller', 'left hand', 'left hand'],
  ['a controller laid aside', ['tracked right controller', ...HANDS], 'right', 'right hand', 'left hand', 'left hand'],
  ['one that is only tracked', ['right controller', 'tracked left hand'], 'right', 'right controller', '', 'tracked left hand'],
  ['a pinch of a hand', [...HANDS, 'right look and pinch'], 'right', 'right look and pinch', 'left hand', 'left hand'],
  ['a pinch of the other', [...HANDS, 'left look and pinch'], 'right', 'right hand', 'left look and pinch', 'left hand'],
  ['pinches alone', ['left look and pinch', 'right look and pinch'], 'right', 'right look and pinch', 'left look and pinch', ''],
  ['a lone pinch of the other', ['left look and pinch'], 'right', '', 'left look and pinch', ''],
  ['a pinch without a side', ['look and pinch'], 'right', 'look and pinch', '', ''],
  ['a gaze', ['gaze'], 'right', 'gaze', '', ''],
  ['a gaze beside a controller', ['gaze', 'left controller'], 'left', 'left controller', 'gaze', ''],
  ['fingers on a screen', ['touch', 'touch'], 'right', 'touch', 'touch', ''],
  ['nobody', [], 'right', '', '', ''],
])('%s', (_what, sources, wished, brush, other, palette) => {
  const all = sources.map(present);
  const roles = rolesOf(all, wished);
  const names = [roles.brush, roles.other, roles.palette].map((one) => one?.name ?? '');
  expect(names).toEqual([brush, other, palette]);
  // The result is deterministic, and no input has the roles of two hands.
  expect(rolesOf(all, wished)).toEqual(roles);
  if (roles.brush) expect([roles.other, roles.palette]).not.toContain(roles.brush);
}); // prettier-ignore
