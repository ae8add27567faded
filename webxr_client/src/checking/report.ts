/** The report of a check: a file, and a copy on the server. */
import { attempt } from '../engine/recordings/recordings';
import { saveFile } from '../net/files';
import { api } from '../net/rest';
import type { HeadsetReportFile } from '../protocol/values';
import { canEdit, notify, state } from '../store/state';
import type { Lesson } from '../xr/input/lessons';
import type { Findings } from './round';
import { outcomeOf, TASKS } from './tasks';

/** Lessons of buttons, by the task that they do. */
const LESSONS = new Map<string, Lesson>(
  TASKS.flatMap(({ name, lesson }) => (lesson ? [[name, lesson]] : [])),
);

export function reportOf({ session, inputs, pictures, buttons }: Findings): HeadsetReportFile {
  const { detail, session: running } = state.xr.peek();
  const tasks = TASKS.map(({ name }) => {
    const lesson = LESSONS.get(name);
    const { verdict } = outcomeOf(name);
    return { name, verdict, by_buttons: lesson !== undefined && buttons.has(lesson) };
  });
  return {
    format: 'pointbrush headset report',
    version: 1,
    made: new Date().toISOString(),
    pointbrush: state.me.peek()?.serverVersion ?? '',
    browser: navigator.userAgent,
    trouble: session || running === 'running' ? '' : detail,
    session,
    inputs: inputs.reports,
    pictures,
    tasks,
  };
}

/** Download the report. */
export function saveReport(findings: Findings): void {
  const report = reportOf(findings);
  saveFile(`headset-report-${report.made.slice(0, 10)}.json`, report);
}

/** Send the report to the server, where managers find it. */
export async function sendReport(findings: Findings): Promise<void> {
  if (!canEdit.peek()) return;
  await attempt('The report was not sent; download it instead', async () => {
    await api('POST', 'headset-reports', reportOf(findings));
    notify('success', 'The report was sent', 'Managers find it in the settings of a project.');
  });
}
