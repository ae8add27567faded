import { expect, test } from 'vitest';
import { projects } from '../engine/recordings/projects';
import type { SequenceInfo } from '../protocol/messages';
import type { ProjectInfo } from '../protocol/values';
import { state, type SequenceSummary } from '../store/state';
import { openWork, tabs, workTab } from './store';

test('the panel begins with tasks where the project has any, and stays at a tab that was chosen', () => {
  state.sequences.value = [{ id: 'room', project: 'night' } as SequenceSummary];
  state.sequence.value = { id: 'room' } as SequenceInfo;
  openWork();
  expect(workTab.value).toBe('findings');
  projects.value = [
    { id: 'night', role: 'annotator', tasks: { open: 1 } } as unknown as ProjectInfo,
  ];
  expect(workTab.value).toBe('tasks');
  openWork('frames');
  openWork();
  expect(workTab.value).toBe('frames');
});

test('the agreement of annotators is for reviewers', () => {
  expect(tabs.value).not.toContain('agreement');
  projects.value = [{ id: 'night', role: 'reviewer', tasks: {} } as unknown as ProjectInfo];
  expect(tabs.value).toContain('agreement');
  openWork('agreement');
  projects.value = [];
  expect(workTab.value).toBe('findings');
});
