/** Text of a notice in the headset: title, reason and remedy, in lines that fit before the eyes. */
import type { Notice } from '../../store/state';
import { lines } from '../drawing/lines';

/** Letters of a line. */
const LINE = 44;
/** Lines of the reason and the remedy together. */
const MOST_LINES = 5;

/** Remedies by title of the server's refusals, as their details only give the reason. */
const REMEDIES: Readonly<Record<string, string>> = {
  Conflict: 'Check the labels here, then try again.',
  Forbidden: 'Ask a manager of the project for a role.',
  'Not authorised': 'Leave and open the page with a valid link.',
  'Label is locked': 'Unlock the label on the page Labels.',
  'Label is hidden': 'Show the label on the page Labels.',
  'Too large': 'Choose a smaller part.',
  'Too many requests': 'Wait a moment, then try again.',
  'Temporarily unavailable': 'Wait a moment, then try again.',
};

export function noticeText({ title, detail }: Pick<Notice, 'title' | 'detail'>): string {
  const remedy = lines(REMEDIES[title] ?? '', LINE);
  const reason = lines(detail, LINE);
  const room = MOST_LINES - remedy.length;
  if (reason.length > room) reason.splice(room - 1, Infinity, `${reason[room - 1]} …`);
  return [...lines(title, LINE), ...reason, ...remedy].join('\n');
}
