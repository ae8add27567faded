/** Short messages about events, at the bottom of the canvas. */
import { actions } from '../../store/actions';
import { state, type Notice } from '../../store/state';
import { Button } from '../parts/controls';
import { Icon, type IconName } from '../../common/icons';

const ICON: Record<Notice['kind'], IconName> = {
  info: 'help',
  success: 'check',
  error: 'warning',
};

export function Toasts() {
  return (
    <ul class="toasts" aria-live="polite">
      {state.notices.value.map((notice) => (
        <li key={notice.id} class="toast card line start" data-kind={notice.kind}>
          <Icon name={ICON[notice.kind]} />
          <div role={notice.kind === 'error' ? 'alert' : undefined}>
            <strong>{notice.title}</strong>
            {notice.times > 1 && <span class="soft small number"> {notice.times} times</span>}
            {notice.detail && <p class="soft small">{notice.detail}</p>}
          </div>
          {notice.action && <Action notice={notice} action={notice.action} />}
          <Button
            icon="close"
            tip="Dismiss"
            small
            onClick={() => actions.page.dismissNotice(notice.id)}
          />
        </li>
      ))}
    </ul>
  );
}

function Action({ notice, action }: { notice: Notice; action: NonNullable<Notice['action']> }) {
  const take = (): void => {
    actions.page.dismissNotice(notice.id);
    action.run();
  };
  return <Button label={action.label} kind="outlined" small onClick={take} />;
}
