import { expect, it } from 'vitest';
import { noticeText } from './notice-text';

it('tells the reason below the title, in lines that fit', () => {
  const detail = 'classifier: expected painted points of two classes in this recording, got one';
  const [title, ...reason] = noticeText({ title: 'The prediction was not applied', detail }).split('\n'); // prettier-ignore
  expect(title).toBe('The prediction was not applied');
  expect(reason.join(' ')).toBe(detail);
  for (const line of reason) expect(line.length).toBeLessThanOrEqual(44);
});

it('adds the remedy that the server does not tell', () => {
  const detail = "label: 'pin' is locked";
  const text = noticeText({ title: 'Label is locked', detail });
  expect(text).toBe(`Label is locked\n${detail}\nUnlock the label on the page Labels.`);
});

it('keeps the remedy where the reason is cut', () => {
  const text = noticeText({ title: 'Conflict', detail: 'revision '.repeat(60) });
  expect(text.split('\n')).toHaveLength(6);
  expect(text).toMatch(/ …\nCheck the labels here, then try again\.$/u);
});

it('is the title alone without a reason', () => {
  expect(noticeText({ title: 'Floor set', detail: '' })).toBe('Floor set');
});
