import { h } from "../dom.js";

export default {
  id: "share",
  title: (text) => text("drawer.share"),
  mount(element, { text }) {
    element.append(h("h2", {}, text("drawer.share")));
    return { show() {}, hide() {}, destroy: () => element.replaceChildren() };
  },
};
