import { computed, effect, signal } from '@preact/signals';
import { expect, it } from 'vitest';
import { peek } from './watch';

it('reads what is newest and depends on nothing', () => {
  const count = signal(1);
  const twice = computed(() => 2 * count.value);
  const seen: number[] = [];
  const end = effect(() => void seen.push(peek(twice)));
  count.value = 4;
  expect(seen).toEqual([2]);
  expect(peek(twice)).toBe(8);
  end();
});

it('reads a signal inside the reading of another', () => {
  const inner = signal('inner');
  const outer = computed(() => `${peek(inner)} in outer`);
  expect([peek(outer), peek(inner)]).toEqual(['inner in outer', 'inner']);
});
