// Turkish: what the examples show, and their groups.

export default {
  "examples.first": "İlk adımlar",
  "examples.surprising": "Şaşırtıcı",
  "examples.driven": "Zorlama ve sürtünme",
  "examples.trees": "Ağaçlar ve zincirler",
  "examples.more": "Diğerleri",
  "preset.single.words":
    "40° açıdan bırakılan tek kol. Periyodu 2,07 s: küçük salınım formülünün verdiğinden % 3 uzun.",
  "preset.side-by-side.words":
    "Birbirine değmeyen iki sarkaç. Biri ötekinden dört kat uzun olduğu için periyodu iki kat uzundur. Bir uzunluğu ya da kütleyi değiştirip karşılaştırın.",
  "preset.double.words": "Küçük salınım yapan iki eşit kol: aynı anda yavaş ve hızlı bir mod.",
  "preset.upright.words":
    "Dik konumdan 5° ötede bırakılır: tepede oyalanır ve periyodu küçük bir salınımınkinden çok daha uzundur.",
  "preset.kapitza.words":
    "Askı noktası saniyede 32 kez aşağı yukarı titrer: sarkaç böylece baş aşağı durur. 11 mm altındaki genlikte düşer.",
  "preset.coupled.words":
    "İki eşit sarkaç, bir yayın dik tuttuğu bir çerçeveye asılıdır. Birincisi salınımını ikincisine verir ve geri alır.",
  "preset.two-to-one.words":
    "0,64 kg ve 0,36 kg kütlelerle bir mod ötekinden tam iki kat hızlıdır: uçlar her yavaş periyotta geri döner.",
  "preset.chaotic-double.words":
    "Yatayın üstünden bırakılır. Kıl payı farklı iki başlangıç saniyeler içinde ayrılır: Karşılaştır bunu gösterir.",
  "preset.double-bars.words":
    "Uçlarında kütle olmayan iki çubuk; masa üstündeki çift sarkaçların çoğu böyledir.",
  "preset.driven-damped.words":
    "Bir motor onu ileri geri çevirir, sürtünme yavaşlatır. 0,9 N m motorla motorun temposunda salınır, 1,07 N m ile ancak iki periyotta bir kendini yineler, buradaki gibi 1,15 N m ile hiç yinelemez: kaosa giden yol.",
  "preset.laboratory-double.words":
    "Yatakları ve ikinci ekleminde motoru olan bir deney düzeneği; on beş sayıyla tanımlanır.",
  "preset.metronome-cart.words":
    "Bir metronomun kolu: üstünde ağırlığı, altında daha ağır bir kütle, yuvarlanan bir arabanın üstünde. Kol ve araba birbirine karşı salınır, masadakinden biraz daha hızlı.",
  "preset.bar-on-stop.words": "Her çarpma hızının %80’ini bırakır; sonunda durur.",
  "preset.clock.words": "Salınım 12°’nin altındayken bir motor onu en altta iter.",
  "preset.paper-four-arms.words":
    "Makaledeki örnek: ikinci eklemde iki kol asılıdır. Yataydan, durgun hâlde bırakılır.",
  "preset.triple.words": "Alt alta üç eşit kol, yataydan bırakılır.",
  "preset.non-standard-triple.words":
    "Birinci kolun ucunda iki kol asılıdır. Bir modda bunlar birbirine karşı salınır, birinci kol durur: bu başlangıç ona yakındır.",
  "preset.chain-10.words":
    "On eşit kol, düz ve yatay bırakılır. Çekme zincir boyunca uca ilerler, uç savrulur.",
  "preset.star.words":
    "Bir ucun çevresinde, tekerlek telleri gibi açılmış sekiz kol. Birbirlerini yalnızca göbek üzerinden etkilerler.",
  "preset.binary-4.words": "Her kol daha kısa ve hafif iki kol taşır; dört kat derinlikte.",
  "preset.whip.words":
    "Uca doğru hafifleyen on altı kol. Ağır uçtaki bir hamle dışa doğru yayılır ve uç kırbaç gibi şaklar.",
  "preset.thor.words": "Hafif bir gövdede ters yönlerde dönen ve eklemi savuran iki ağır kol.",
  "preset.octopus.words": "Ağır bir başta dörder kollu dört dokunaç.",
  "preset.mobile.words":
    "Uzunluğu ve kütlesi çok farklı kollar: yavaş, ağır bir salınımın üstünde hızlı ve hafif olanlar.",
};
