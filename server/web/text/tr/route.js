// Turkish: the keys of en/route.js.

export default {
  "route.intro":
    "Sürücü kaosa nasıl götürür: ilk 80 periyottan sonra, sürücünün her periyodunda bir kez bakılan açı, sürücünün gücüne göre. Bir nokta sürücüyle birlikte salınımdır, iki nokta iki kat periyotlu bir salınımdır, bir bulut kaostur.",
  "route.from": "En az güç",
  "route.to": "En çok güç",
  "route.strength": "sürücünün gücü, {unit}",
  "route.plot": "Sürücünün her periyodunda bir kez açı, gücüne göre",
  "route.hint": "Bir güce tıklayın: sarkaç onunla sürülür. Yukarıdaki sürgüler de aynısını yapar.",
  "route.none":
    "Bu sarkacı ileri geri süren bir şey yok: ona bir motor verin ya da askı noktasını sallayın.",
};
