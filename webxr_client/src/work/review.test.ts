import { beforeEach, expect, test } from 'vitest';
import { labelActions } from '../engine/labels';
import type { Label } from '../protocol/messages';
import { bindActions } from '../store/actions';
import { state } from '../store/state';
import type { Finding } from './model';
import { goToFinding } from './review';

const finding = (...labels: number[]) => ({ id: labels.join(), labels, first: null }) as unknown as Finding; // prettier-ignore

beforeEach(() => {
  bindActions(labelActions);
  state.palette.value = [1, 2, 3].map((id) => ({ id, name: `pin ${id}` }) as Label);
  state.activeLabel.value = 1;
  state.notices.value = [];
});

test('a finding about several labels, or none, leaves the label of the next stroke', () => {
  for (const labels of [[2, 3], [1, 2], []]) {
    goToFinding(finding(...labels));
    expect(state.activeLabel.value).toBe(1);
  }
  expect(state.notices.value).toEqual([]);
});

test('a finding about one label selects it and announces the change once', () => {
  goToFinding(finding(3));
  goToFinding(finding(3));
  expect(state.activeLabel.value).toBe(3);
  expect(state.notices.value.map(({ title, times }) => [title, times])).toEqual([
    ['Active label: pin 3', 1],
  ]);
});
