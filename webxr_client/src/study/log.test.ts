import { expect, it } from 'vitest';
import { ApiError } from '../net/rest';
import type { LogPosition, LogRecord, LogRecords } from '../protocol/values';
import { keptJson } from '../store/kept';
import { Log } from './log';

const record = (t: number): LogRecord => ({ kind: 'undo', step: 3, t });
const times = (records: readonly LogRecord[]): number[] => records.map(({ t }) => t);

/** A server that refuses gaps and changed records, as ours does. */
class Server {
  readonly log: LogRecord[] = [];
  readonly calls: number[] = [];
  /** Answers of the next calls: taken, unreachable, or taken without an answer. */
  faults: ('lost' | 'unanswered')[] = [];

  readonly send = ({ first, records }: LogRecords): Promise<LogPosition> => {
    const fault = this.faults.shift();
    this.calls.push(records.length);
    if (fault === 'lost') return Promise.reject(new ApiError('No connection', '', 0));
    if (first > this.log.length) throw new ApiError('Conflict', 'a gap', 409);
    const known = this.log.slice(first, first + records.length);
    expect(times(records).slice(0, known.length)).toEqual(times(known));
    this.log.push(...records.slice(known.length));
    if (fault) return Promise.reject(new ApiError('No connection', '', 0));
    return Promise.resolve({ next: first + records.length });
  };
}

it('numbers records without gaps over lost calls, lost answers and a reload', async () => {
  const server = new Server();
  const log = new Log(0, 'lost', server.send);
  log.add(record(1));
  await log.flush();
  server.faults = ['lost', 'unanswered'];
  log.add(record(2));
  await expect(log.flush()).rejects.toThrow('No connection');
  log.add(record(3));
  await expect(log.flush()).rejects.toThrow('No connection');
  log.add(record(4));
  log.keep();
  expect(times(server.log)).toEqual([1, 2, 3]);

  const next = new Log(server.log.length, 'lost', server.send);
  next.add(record(5));
  await next.flush();
  expect(times(server.log)).toEqual([1, 2, 3, 4, 5]);
  expect(keptJson('lost')).toEqual({ first: 5, records: [] });
});

it('sends one batch at a time, of the size that the server takes', async () => {
  const server = new Server();
  const log = new Log(0, 'batches', server.send);
  for (let t = 0; t < 2500; t++) log.add(record(t));
  await Promise.all([log.flush(), log.flush()]);
  expect(server.calls).toEqual([1000, 1000, 500]);
  expect(server.log.length).toBe(2500);
});

it('reports records that the server refuses, and keeps them', async () => {
  const server = new Server();
  const log = new Log(7, 'refused', server.send);
  log.add(record(1));
  await expect(log.flush()).rejects.toThrow('a gap');
  expect(keptJson('refused')).toEqual({ first: 7, records: [record(1)] });
});
