/** Text of a notice in the headset: title, reason and remedy, in lines that fit before the eyes. */
import type { Notice } from '../../store/state';

/** Letters of a line. */
const LINE = 44;
/** Lines of the reason and the remedy together. */
const MOST_LINES = 5;

/** Remedies for the titles of the server's refusals, whose details name the reason alone. */
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

/** Break text at blanks into lines of at most `LINE` letters; a longer word keeps its line. */
export function lines(text: string): string[] {
  const found = [''];
  for (const word of text.split(/\s+/u)) {
    const last = found.at(-1)!;
    if (last && last.length + 1 + word.length > LINE) found.push(word);
    else found[found.length - 1] = last ? `${last} ${word}` : word;
  }
  return found.filter(Boolean);
}

export function noticeText({ title, detail }: Pick<Notice, 'title' | 'detail'>): string {
  const remedy = lines(REMEDIES[title] ?? '');
  const reason = lines(detail);
  const room = MOST_LINES - remedy.length;
  if (reason.length > room) reason.splice(room - 1, Infinity, `${reason[room - 1]} …`);
  return [...lines(title), ...reason, ...remedy].join('\n');
}
