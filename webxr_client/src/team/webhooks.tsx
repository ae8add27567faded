/** Settings of a project: addresses that receive its events. */
import type { Delivery, ProjectInfo, Webhook } from '../protocol/values';
import { useEffect, useState } from 'preact/hooks';
import { day, plural } from '../common/format';
import { Button, Check } from '../panels/parts/controls';
import { addWebhook, deliveries, loadWebhooks, removeWebhook, secret, webhooks } from './settings';

const TOPICS = [
  ['task', 'Task states'],
  ['labels', 'Edits, once a minute'],
  ['job', 'Finished jobs'],
] as const;
/** Events of a webhook that are listed. */
const LISTED = 5;

export function Webhooks({ of }: { of: ProjectInfo }) {
  useEffect(() => void loadWebhooks(), [of.id]);
  return (
    <>
      {webhooks.value.length === 0 && <p class="soft">No webhooks yet.</p>}
      <ul class="settings-rows stack">
        {webhooks.value.map((each) => (
          <li key={each.id} class="stack">
            <Entry webhook={each} />
          </li>
        ))}
      </ul>
      <Add />
    </>
  );
}

function Entry({ webhook }: { webhook: Webhook }) {
  const events = deliveries.value.get(webhook.id) ?? [];
  const failing = events.filter(({ error, delivered }) => error && !delivered).length;
  const own = secret.value?.webhook === webhook.id ? secret.value.words : null;
  return (
    <>
      <div class="line">
        <strong class="name">{webhook.url}</strong>
        <span class="soft">{webhook.topics.join(', ')}</span>
        <Button
          icon="trash"
          tip={`Remove the webhook ${webhook.url}`}
          small
          onClick={() => void removeWebhook(webhook)}
        />
      </div>
      {webhook.paused_until && (
        <p class="bad">
          The receiver does not answer. Next attempt at{' '}
          {new Date(webhook.paused_until).toLocaleTimeString()}.
        </p>
      )}
      {own && (
        <p class="note line wrap" role="status">
          Secret, shown only once: <code>{own}</code>
        </p>
      )}
      <details open={failing > 0}>
        <summary>
          {plural(events.length, 'event')}
          {failing > 0 && <span class="bad">, {failing} not delivered</span>}
        </summary>
        <ul>
          {events.slice(0, LISTED).map((each) => (
            <li key={each.id}>
              {each.topic} · {day(each.created)} · {outcome(each)}
            </li>
          ))}
        </ul>
      </details>
    </>
  );
}

function outcome({ delivered, attempts, error }: Delivery): string {
  if (delivered) return attempts > 1 ? `delivered at attempt ${attempts}` : 'delivered';
  return error ? `${plural(attempts, 'attempt')}: ${error}` : 'waiting';
}

function Add() {
  const [url, setUrl] = useState('');
  const [topics, setTopics] = useState<readonly string[]>(TOPICS.map(([topic]) => topic));
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (await addWebhook(url.trim(), topics)) setUrl('');
  };
  return (
    <form class="stack" onSubmit={(event) => void submit(event)}>
      <div class="line">
        <input
          class="field grow"
          type="url"
          aria-label="Address of the webhook"
          placeholder="https://lab.example.org/hook"
          maxLength={2000}
          value={url}
          onInput={(event) => setUrl(event.currentTarget.value)}
        />
        <Button submit label="Add" kind="primary" disabled={!url.trim() || topics.length === 0} />
      </div>
      <div class="group">
        {TOPICS.map(([topic, words]) => (
          <Check
            key={topic}
            label={words}
            checked={topics.includes(topic)}
            onChange={(on) =>
              setTopics(on ? [...topics, topic] : topics.filter((each) => each !== topic))
            }
          />
        ))}
      </div>
    </form>
  );
}
