/** Limits of the page while it shows a task of a study. */
import { signal } from '@preact/signals';
import type { ComponentChild } from 'preact';

export interface Limits {
  /** Names of tools, shapes and actions that are offered; empty: all; null: none, for a pause. */
  readonly tools: readonly string[] | null;
  readonly hints: boolean;
  /** Content of the tool bar in place of the recording's name. */
  readonly Bar: () => ComponentChild;
}

/** Null: no study. */
export const limits = signal<Limits | null>(null);

/** Return whether a tool, a shape or an action is offered, by its name. */
export function offers(name: string): boolean {
  const { value } = limits;
  if (!value || name === 'navigate' || value.tools?.length === 0) return true;
  // A shape that is offered needs the tool that paints with it.
  return value.tools !== null && (name === 'paint' || value.tools.includes(name));
}
