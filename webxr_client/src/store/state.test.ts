import { beforeEach, expect, it } from 'vitest';
import { notify, state } from './state';

beforeEach(() => {
  state.notices.value = [];
});

it('counts a message that comes again up, in place of another', () => {
  notify('error', 'The label was not made', 'No room');
  notify('info', 'Saved');
  notify('error', 'The label was not made', 'No room');
  notify('error', 'The label was not made', 'Away');
  expect(state.notices.value.map(({ title, detail, times }) => [title, detail, times])).toEqual([
    ['Saved', '', 1],
    ['The label was not made', 'No room', 2],
    ['The label was not made', 'Away', 1],
  ]);
});
