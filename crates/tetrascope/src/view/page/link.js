// The WebSocket: what it brings and what it takes; lost, it is opened again.

"use strict";

const link = (() => {
  let socket = null;
  let seq = 0;
  let tries = 0;
  let timer = null;
  const sentAt = new Map();
  const pending = new Map(); // the newest command of each kind, until the next screen
  let scheduled = false;

  function open() {
    clearTimeout(timer);
    const url = new URL("ws", location.href.split("#")[0]);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    const mine = new WebSocket(url);
    socket = mine;
    mine.binaryType = "arraybuffer";
    mine.onmessage = (event) => {
      if (mine !== socket) return;
      if (typeof event.data === "string") take(JSON.parse(event.data));
      else picture.take(event.data);
    };
    mine.onclose = (event) => {
      if (mine === socket) lost(event);
    };
  }

  function lost(event) {
    socket = null;
    picture.forget();
    // Refused in words: trying again at once does no good.
    const words = event.reason;
    const wait = Math.min(500 * 2 ** tries, 8000);
    tries += 1;
    if (words || tries > 1) {
      $("gone").hidden = false;
      $("gone-text").textContent = words
        ? `It says: ${words}.`
        : "It may have ended, or the tunnel to it is closed. This page tries again by itself; the view is kept.";
    }
    $("status-link").textContent = "not connected";
    timer = setTimeout(async () => {
      // A server that is there and knows the address no more says so.
      try {
        const answer = await fetch("icon.svg", { cache: "no-store" });
        if (answer.status === 403) {
          $("gone").hidden = false;
          $("gone-text").textContent = "Another viewer answers here: " + (await answer.text());
        }
      } catch { /* Nobody is there. */ }
      open();
    }, wait);
  }

  function take(message) {
    switch (message.type) {
      case "hello":
        tries = 0;
        $("gone").hidden = true;
        $("status-link").textContent = "";
        if (hello && hello.run !== message.run) restoring = undefined;
        hello = message;
        panels.catalog();
        break;
      case "field":
        field = message;
        panels.field();
        editor.field();
        break;
      case "state":
        takeState(message);
        break;
      case "camera":
        if (message.by !== hello.client) camera.take(message.camera);
        break;
      case "estimate":
        estimate = message.estimate;
        knowledge.tell();
        break;
      case "histogram":
        editor.histogram(message);
        break;
      case "progress":
        knowledge.progress(message);
        break;
      case "problem":
        say(message.message, message.help, true);
        if (message.state) takeState(message.state);
        knowledge.working(null);
        steps.stop();
        break;
      case "note":
        say(message.message);
        break;
    }
  }

  function takeState(message) {
    const isFirst = state === null || restoring === undefined;
    state = message;
    if (!camera.isHeld()) camera.take(message.camera);
    panels.state();
    editor.state();
    if (isFirst) restore();
    keep();
  }

  // A link's view, or that of a server which has started anew.
  let restoring;
  function restore() {
    restoring = null;
    let saved = null;
    if (location.hash.length > 1) {
      try {
        saved = JSON.parse(new TextDecoder().decode(fromBase64(location.hash.slice(1))));
      } catch {
        say("The view in this address is damaged and passed over.", null, true);
      }
      history.replaceState(null, "", location.href.split("#")[0]);
    } else {
      const kept = JSON.parse(sessionStorage.getItem("view") ?? "null");
      if (kept && kept.run !== hello.run && kept.name === field.name) saved = kept.saved;
    }
    if (saved) command({ do: "restore", saved });
    picture.tellSize(hello.is_first || saved !== null);
  }

  function keep() {
    const kept = { run: hello.run, name: field.name, saved: state.saved };
    sessionStorage.setItem("view", JSON.stringify(kept));
  }

  function send(message) {
    if (!socket || socket.readyState !== WebSocket.OPEN) return 0;
    seq += 1;
    sentAt.set(seq, performance.now());
    if (sentAt.size > 500) sentAt.delete(sentAt.keys().next().value);
    socket.send(JSON.stringify({ seq, ...message }));
    return seq;
  }

  /** A change, at once. */
  const command = (command, moving = false) => {
    pending.delete(command.do);
    return send({ command, moving });
  };

  /** A change while a hand moves: the newest of its kind, with the next screen. */
  function drag(command) {
    pending.set(command.do, command);
    if (scheduled) return;
    scheduled = true;
    requestAnimationFrame(() => {
      scheduled = false;
      for (const command of pending.values()) send({ command, moving: true });
      pending.clear();
    });
  }

  return {
    open, send, command, drag,
    shown: (id) => socket?.readyState === WebSocket.OPEN && socket.send(`{"shown":${id}}`),
    since: (of) => (sentAt.has(of) ? performance.now() - sentAt.get(of) : null),
    retry: () => { tries = 0; open(); },
  };
})();

const toBase64 = (bytes) => btoa(String.fromCharCode(...bytes)).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");
const fromBase64 = (text) => Uint8Array.from(atob(text.replace(/-/g, "+").replace(/_/g, "/")), (c) => c.charCodeAt(0));
