/** What happened: short messages in the corner. */
import { actions } from '../actions';
import { state, type Notice } from '../state';
import { Button } from './controls';
import { Icon } from './icon';
import type { IconName } from './icons';

const ICON: Record<Notice['kind'], IconName> = {
  info: 'help',
  success: 'check',
  error: 'warning',
};

export function Toasts() {
  return (
    <ul class="toasts" aria-live="polite">
      {state.notices.value.map((notice) => (
        <li
          key={notice.id}
          class="toast"
          data-kind={notice.kind}
          role={notice.kind === 'error' ? 'alert' : undefined}
        >
          <Icon name={ICON[notice.kind]} />
          <div>
            <strong>{notice.title}</strong>
            {notice.detail && <p>{notice.detail}</p>}
          </div>
          <Button
            icon="close"
            tip="Dismiss"
            small
            onClick={() => actions.dismissNotice(notice.id)}
          />
        </li>
      ))}
    </ul>
  );
}
