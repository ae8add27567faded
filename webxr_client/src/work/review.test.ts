import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { labelActions } from '../engine/labels/labels';
import type { Label, SequenceInfo } from '../protocol/messages';
import type { Finding } from '../protocol/values';
import { bindActions } from '../store/actions';
import { state } from '../store/state';
import { checks, current, deny, goToFinding } from './review';

const finding = (...labels: number[]) => ({ id: labels.join(), labels, first: null }) as unknown as Finding; // prettier-ignore

beforeEach(() => {
  bindActions(labelActions);
  state.palette.value = [1, 2, 3].map((id) => ({ id, name: `pin ${id}` }) as Label);
  state.activeLabel.value = 1;
  state.notices.value = [];
});

afterEach(() => vi.unstubAllGlobals());

test('the answer that it is another object clears the label in the frames of the finding', async () => {
  const sent: unknown[] = [];
  vi.stubGlobal('document', { baseURI: 'http://host/' });
  vi.stubGlobal('fetch', (url: string, { method, body }: RequestInit) => {
    sent.push([method, url.replace('http://host/api/v1/', ''), JSON.parse(body as string)]);
    return Promise.resolve(Response.json({}));
  });
  state.sequence.value = { id: 'room', frames: 99 } as SequenceInfo;
  const [asks, other] = [{ ...finding(2), first: 12, last: 40 }, finding(3)];
  checks.value = { findings: [asks, other], unchecked: [] };
  await deny(asks);
  expect(sent).toEqual([['POST', 'sequences/room/clear', { labels: [2], start: 12, stop: 40 }]]);
  expect(current.value).toBe(other.id);
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
