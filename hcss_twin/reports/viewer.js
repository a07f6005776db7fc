(() => {
  "use strict";
  const root = document.querySelector(".viewer");
  const find = (what) => root.querySelector(what);
  const select = find("select.quantity"), bands = find("select.part"), slider = find("input[type=range]");
  const play = find("button.play"), image = find(".stage img"), stills = [...root.querySelectorAll(".stills figure")];
  const state = { quantity: 0, part: 0, place: 0 };
  let timer = null;

  const quantity = () => VIEW.quantities[state.quantity];
  const part = () => quantity().parts[state.part];
  const address = (content) => "data:image/png;base64," + content;
  // The first frames of the first quantity are in the page already.
  VIEW.quantities[0].parts.forEach((each, number) => {
    each.pictures[0] = stills[number].querySelector("img").src.split(",")[1];
  });

  function told(each, place) {
    const frame = VIEW.frames[each.frames[place]];
    return `frame ${frame.number}, ${frame.time}`;
  }

  function show() {
    const one = quantity(), shown = part();
    const frame = VIEW.frames[one.frames[state.place]];
    image.src = address(shown.pictures[state.place]);
    image.alt = `${one.label} ${shown.name}, ${told(one, state.place)}`;
    find(".stage .sky").classList.toggle("coarse", one.coarse);
    find(".stage .scale").innerHTML = shown.bar;
    find(".stage .frame").textContent = told(one, state.place);
    find(".stage .instant").textContent = frame.instant;
    find(".stage .sun").textContent = frame.sun;
    for (const name of ["mean", "lowest", "highest"]) {
      find(".stage ." + name).textContent = shown.numbers[state.place][name];
    }
    find(".stage .units").textContent = one.units;
    slider.max = one.frames.length - 1;
    slider.value = state.place;
    slider.disabled = play.disabled = find(".controls .time").hidden = one.frames.length < 2;
    slider.setAttribute("aria-valuetext", told(one, state.place));
    select.value = state.quantity;
    bands.value = state.part;
    root.dataset.frame = frame.number;
    root.dataset.part = shown.name;
    root.dataset.quantity = one.name;
  }

  function fill(list, names) {
    list.replaceChildren(...names.map((name, value) => new Option(name, value)));
  }

  function nearest(each, number) {
    const away = each.frames.map((frame) => Math.abs(VIEW.frames[frame].number - number));
    return away.indexOf(Math.min(...away));
  }

  function choose(number, name) {
    const frame = VIEW.frames[quantity().frames[state.place]].number;
    const before = name ?? part().name;
    state.quantity = number;
    const names = quantity().parts.map((each) => each.name);
    fill(bands, names.map((each) => each || "all"));
    find("label.parts").hidden = names.length < 2;
    find("label.parts span").textContent = quantity().dim || "";
    state.part = Math.max(0, names.indexOf(before));
    state.place = nearest(quantity(), frame);
    show();
  }

  function step(by) {
    const count = quantity().frames.length;
    state.place = (state.place + by + count) % count;
    show();
  }

  function stop() {
    clearInterval(timer);
    timer = null;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  }

  function start() {
    timer = setInterval(() => step(1), VIEW.milliseconds);
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
  }

  function remember() {
    history.replaceState(null, "", `#frame=${root.dataset.frame}&show=${root.dataset.quantity}` +
      (part().name ? `&band=${encodeURIComponent(part().name)}` : ""));
  }

  // #frame=12&band=mwir&show=cloud_mask: numbers and names as in the cube; a band may be given by its number, too
  function recall() {
    const asked = new URLSearchParams(location.hash.slice(1));
    if (!["frame", "band", "show"].some((key) => asked.has(key))) return;
    const number = VIEW.quantities.findIndex((each) => each.name === asked.get("show"));
    const chosen = number < 0 ? state.quantity : number;
    const names = VIEW.quantities[chosen].parts.map((each) => each.name);
    const band = asked.get("band");
    const numbered = VIEW.quantities[chosen].parts.find((each) => each.number === Number(band));
    choose(chosen, names.includes(band) || band === null ? band ?? undefined : numbered?.name);
    if (asked.has("frame")) state.place = nearest(quantity(), Number(asked.get("frame")));
    show();
  }

  function forPaper() {
    // the stills are of the first quantity: its frame that is nearest to the one chosen
    stills.forEach((still, number) => {
      const one = VIEW.quantities[0], shown = one.parts[number];
      const place = nearest(one, VIEW.frames[quantity().frames[state.place]].number);
      still.querySelector("img").src = address(shown.pictures[place]);
      still.querySelector(".frame").textContent = told(one, place);
    });
  }

  fill(select, VIEW.quantities.map((each) => each.label));
  select.addEventListener("change", () => { choose(Number(select.value)); remember(); });
  bands.addEventListener("change", () => { state.part = Number(bands.value); show(); remember(); });
  slider.addEventListener("input", () => { stop(); state.place = Number(slider.value); show(); });
  slider.addEventListener("change", remember);
  play.addEventListener("click", () => { if (timer === null) { start(); } else { stop(); remember(); } });
  const moves = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity };
  root.addEventListener("keydown", (event) => {
    const own = event.target === slider || event.target.tagName === "SELECT";
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key in moves && !own) {
      stop();
      const by = moves[event.key];
      if (Number.isFinite(by)) { step(by); } else { state.place = by < 0 ? 0 : quantity().frames.length - 1; show(); }
    } else if (event.key === " " && event.target === root) {
      play.click();
    } else if (event.key === "b" && event.target.tagName !== "SELECT") {
      state.part = (state.part + 1) % quantity().parts.length;
      show();
    } else if (event.key === "q" && event.target.tagName !== "SELECT") {
      choose((state.quantity + 1) % VIEW.quantities.length);
    } else {
      return;
    }
    event.preventDefault();
    remember();
  });
  window.addEventListener("hashchange", recall);
  window.addEventListener("beforeprint", forPaper);
  root.classList.add("live");
  choose(0);
  recall();
})();
