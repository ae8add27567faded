/** Reports of headset checks, for managers. */
import { useEffect, useState } from 'preact/hooks';
import { ago } from '../common/format';
import { attempt } from '../engine/recordings/recordings';
import { saveFile } from '../net/files';
import { api } from '../net/rest';
import { Button } from '../panels/parts/controls';
import type { HeadsetReport } from '../protocol/values';

export function HeadsetReports() {
  const [reports, setReports] = useState<readonly HeadsetReport[]>([]);
  useEffect(() => {
    void attempt('The headset reports did not load', async () =>
      setReports(await api('GET', 'headset-reports')),
    );
  }, []);
  if (reports.length === 0) return null;
  return (
    <section class="settings-webhook" aria-label="Headset checks">
      <h3>Headset checks</h3>
      <ul class="settings-rows" tabIndex={0} aria-label="Headset reports">
        {reports.map((each) => (
          <Row key={each.id} of={each} />
        ))}
      </ul>
    </section>
  );
}

function Row({ of: { account, received, report } }: { of: HeadsetReport }) {
  const works = report.tasks.filter(({ verdict }) => verdict === 'works').length;
  return (
    <li class="line">
      <span class="name">{[...new Set(report.inputs.map(({ layout }) => layout))].join(', ')}</span>
      <span class="soft">
        {`${works} of ${report.tasks.length} work · ${account} · ${ago(received)}`}
      </span>
      <Button
        icon="export"
        tip="Download the report"
        small
        onClick={() => saveFile(`headset-report-${received.slice(0, 10)}.json`, report)}
      />
    </li>
  );
}
