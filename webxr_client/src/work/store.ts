/** The Work panel: whether it is open, its tab, and the project of the open recording. */
import { computed, signal } from '@preact/signals';
import { may, openProject, tasksOf } from '../engine/recordings/projects';

const ALL = ['tasks', 'findings', 'frames', 'agreement', 'versions'] as const;
export type WorkTab = (typeof ALL)[number];

export const workOpen = signal(false);
/** The tab that was chosen; null: tasks where the project has any, or findings. */
const chosenTab = signal<WorkTab | null>(null);
export const project = computed(openProject);

/** Tabs in the order of use: the agreement of annotators is for reviewers. */
export const tabs = computed(() =>
  ALL.filter((tab) => tab !== 'agreement' || may(project.value, 'reviewer')),
);
export const workTab = computed<WorkTab>(() => {
  const first = tasksOf(project.value?.tasks ?? {}) > 0 ? 'tasks' : 'findings';
  return tabs.value.find((tab) => tab === chosenTab.value) ?? first;
});

/** Open the panel, at a tab or where it was. */
export function openWork(tab: WorkTab | null = chosenTab.peek()): void {
  chosenTab.value = tab;
  workOpen.value = true;
}

/** True while a tab is on screen. */
export const shows = (tab: WorkTab): boolean => workOpen.value && workTab.value === tab;
