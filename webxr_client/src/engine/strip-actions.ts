/** Actions on labels in a stretch of frames, from the timeline. */
import type { Actions } from '../actions';
import { api } from '../net/rest';
import { state } from '../state';
import { attempt, sequencePath } from './recordings';

function frames(frame: number): string {
  return `${sequencePath(state.sequence.peek()?.id ?? '')}/frames/${frame}`;
}

export const stripActions: Pick<Actions, 'clearLabels' | 'copyLabels' | 'acceptLabels'> = {
  clearLabels: (labels, from, to) =>
    attempt('The labels were not cleared', () =>
      api('POST', `${frames(from)}/clear`, { labels, stop: to }),
    ),
  copyLabels: (labels, source, frame) =>
    attempt('The labels were not copied', () =>
      api('POST', `${frames(frame)}/copy`, { labels, source }),
    ),
  acceptLabels: (labels, frame) =>
    attempt('The frame was not accepted', () => api('POST', `${frames(frame)}/accept`, { labels })),
};
